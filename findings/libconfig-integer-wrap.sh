#!/usr/bin/env bash
# libconfig 1.5 (Debian 12): an integer literal of 2^31 or more without the suffix L is read with success and wraps to a
# 32-bit value, where a range error would be expected: the reader keeps the low 32 bits and never says so. A look-up as
# a 64-bit integer gives the wrapped value too.
# Needs: apt-get (to download, nothing is installed), dpkg-deb, cc. Fails if what it sees changes.
set -euo pipefail
version=1.5-0.4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get -qq download "libconfig-dev=$version" "libconfig9=$version" 2>/dev/null
for package in *.deb; do dpkg-deb -x "$package" root; done
cat >probe.c <<'C'
#include <libconfig.h>
#include <stdio.h>
int main(void)
{
    static const char *const text[] = {"x = 2147483647;", "x = 2147483648;", "x = 5000000000;", "x = 5000000000L;"};
    for (int k = 0; k < 4; k++) {
        config_t config;
        long long value = 0;
        config_init(&config);
        const int read = config_read_string(&config, text[k]), found = config_lookup_int64(&config, "x", &value);
        printf("%s read %d found %d value %lld\n", text[k], read, found, value);
        config_destroy(&config);
    }
    return 0;
}
C
library=$(dirname "$(find root -name 'libconfig.so.9')")
cc -o probe probe.c -I root/usr/include "$library/libconfig.so.9" -Wl,-rpath,"$folder/$library"
./probe >seen
cat >expected <<'TEXT'
x = 2147483647; read 1 found 1 value 2147483647
x = 2147483648; read 1 found 1 value -2147483648
x = 5000000000; read 1 found 1 value 705032704
x = 5000000000L; read 1 found 1 value 5000000000
TEXT
echo "libconfig $version:"
cat seen
diff expected seen && echo "as described: literals from 2^31 on wrap without an error"
