#!/usr/bin/env bash
# VTK of ParaView 5.11 (Debian 12) with the libexpat of Debian's updates (2.5.0-1+deb12u5; u2 as well): a VTK XML file
# with appended data, which the VTK format has and writers choose by default, is refused ("not well-formed") once the
# data are longer than what the reader hands to the parser at a time; 3 points are read, 20 000 are not, raw and base64
# alike. With libexpat 2.5.0-1+deb12u1 all are read. The same numbers inline are read by all.
# Needs: pvpython (python3-paraview 5.11.0+dfsg-1+b1 and what it depends on), apt-get (to download; nothing is
# installed), dpkg-deb. Fails if what it sees changes.
set -euo pipefail
version='2.5.0-1+deb12u5'
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get -qq download "libexpat1=$version" 2>/dev/null
dpkg-deb -x libexpat1_*.deb root
LD_LIBRARY_PATH=$(dirname "$(find "$folder/root" -name 'libexpat.so.1')")

cat >points.py <<'PYTHON'
import base64, struct
from paraview.simple import XMLPolyDataReader

HEAD = ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32">\n'
        '<PolyData><Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">\n'
        '<Points><DataArray type="Float32" NumberOfComponents="3" ')
CLOSE = '</Points></Piece></PolyData>\n'
for count in (3, 20000):
    values = [0.5 * k for k in range(3 * count)]
    block = struct.pack('<I', 12 * count) + struct.pack('<%df' % (3 * count), *values)
    inline = 'format="ascii">' + ' '.join(map(str, values)) + '</DataArray>' + CLOSE
    contents = {'inline': (HEAD.format(count) + inline).encode()}
    for kind, data in (('raw', block), ('base64', base64.b64encode(block))):
        head = HEAD.format(count) + 'format="appended" offset="0"/>' + CLOSE + '<AppendedData encoding="%s">\n_' % kind
        contents[kind] = head.encode() + data + b'\n</AppendedData>\n'
    for kind, text in contents.items():
        with open('points.vtp', 'wb') as file:
            file.write(text + b'</VTKFile>\n')
        reader = XMLPolyDataReader(FileName=['points.vtp'])
        reader.UpdatePipeline()
        print('%d points, %s: %d read' % (count, kind, reader.GetDataInformation().GetNumberOfPoints()))
PYTHON
report=$(LD_LIBRARY_PATH=$LD_LIBRARY_PATH pvpython points.py 2>/dev/null | grep ' read$')
echo "ParaView with libexpat $version:"
echo "$report"
[ "$report" = "3 points, inline: 3 read
3 points, raw: 3 read
3 points, base64: 3 read
20000 points, inline: 20000 read
20000 points, raw: 0 read
20000 points, base64: 0 read" ] && echo 'as described: appended data are refused'
