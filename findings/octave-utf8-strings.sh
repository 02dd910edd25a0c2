#!/usr/bin/env bash
# Octave 7.3 (Debian 12) cannot load an HDF5 text whose type says UTF-8, of fixed or of variable length, although its
# bytes are plain letters: load fails with "error while reading hdf5 item". The same text in a type that says ASCII and
# has a fixed length is read. h5py writes texts as UTF-8 of variable length unless it is told otherwise.
# Needs octave and libhdf5-dev of Debian 12: apt-get install octave libhdf5-dev; cc. Fails if what it sees changes.
set -euo pipefail
version=7.3.0-2
installed=$(dpkg-query -W -f='${Version}' octave 2>/dev/null || true)
[ "$installed" = "$version" ] || { echo "octave $version is not installed (found: ${installed:-none})"; exit 125; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >make.c <<'C'
#include <hdf5.h>
static int put(hid_t file, const char *name, size_t size, H5T_cset_t letters)
{
    const char *text = "abc";
    hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    if (H5Tset_size(type, size) < 0 || H5Tset_cset(type, letters) < 0)
        return 1;
    hid_t id = H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    return H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, size == H5T_VARIABLE ? (void *)&text : (void *)text) < 0 || H5Dclose(id) < 0;
}
int main(void)
{
    hid_t file = H5Fcreate("texts.h5", H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    return put(file, "ascii_fixed", 4, H5T_CSET_ASCII) || put(file, "utf8_fixed", 4, H5T_CSET_UTF8) ||
           put(file, "utf8_variable", H5T_VARIABLE, H5T_CSET_UTF8) || H5Fclose(file) < 0;
}
C
read -ra flags < <(pkg-config --cflags --libs hdf5)
cc -o make make.c "${flags[@]}"
./make
for name in ascii_fixed utf8_fixed utf8_variable; do
    if said=$(octave-cli --no-gui --quiet --eval "x = load('texts.h5', '$name'); printf('%s', x.$name)" 2>/dev/null) && [ "$said" = abc ]; then
        echo "$name: read"
    else
        echo "$name: not read"
    fi
done >seen
cat >expected <<'TEXT'
ascii_fixed: read
utf8_fixed: not read
utf8_variable: not read
TEXT
echo "octave $version:"
cat seen
diff expected seen && echo "as described: texts that say UTF-8 are not read"
