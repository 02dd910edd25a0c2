#!/usr/bin/env bash
# test_readers.sh SIM RECORDER SCENE READING.MD: readers that are not ours, on a real run, with the examples of
# docs/reading.md as they stand there. One that is not installed is skipped, and says so; 125 if none is.
set -uo pipefail
sim=$1 recorder=$2 scene=$3 page=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
tried=0

fail() {
    echo "FAILED: $*"
    cat said.txt
    exit 1
}

# Debian's modules are with Debian's Python, whatever else comes first on the path.
python_with() { # MODULE
    local python
    for python in python3 /usr/bin/python3; do
        "$python" -c "import $1" >/dev/null 2>&1 && echo "$python" && return
    done
}

# The fenced example of a language that begins with WORD.
example() { # LANGUAGE WORD
    awk -v fence="\`\`\`$1" -v word="$2" '
        $0 == fence { inside = 1; text = ""; next }
        /^```/ && inside { inside = 0; if (index(text, word) == 1) printf "%s", text; next }
        inside { text = text $0 "\n" }' "$page"
}

try() { # NAME EXPECTED-TEXT COMMAND...
    local name=$1 expected=$2
    shift 2
    "$@" >said.txt 2>&1 || fail "$name ends with $?"
    grep -qE "$expected" said.txt || fail "$name does not say $expected"
    echo "$name: read"
    tried=$((tried + 1))
}

"$sim" "$scene" --in-process --lcm "file://$folder/run.lcm?mode=w" >said.txt 2>&1 || fail "sim"
"$recorder" --from run.lcm --out . >said.txt 2>&1 || fail "recorder"
"$recorder" --verify . >said.txt 2>&1 || fail "verify"

if command -v h5dump >/dev/null; then
    try h5ls strain h5ls -r run.h5
    try h5dump '^   \(0\): 1' h5dump -a /complete run.h5
else
    echo "SKIPPED: hdf5-tools is not installed"
fi
for module in h5py MDAnalysis; do
    python=$(python_with $module)
    if [ -n "$python" ]; then
        example python "import $module" >example.py
        [ -s example.py ] || fail "no example of $module"
        [ $module = h5py ] && expected='^complete 1 status 0' || expected='^positions \(300, 3\)'
        try $module "$expected" "$python" example.py
    else
        echo "SKIPPED: $module is not installed"
    fi
done
# The same example as a notebook: a kernel of Jupyter runs it, and keeps the file open.
cat >notebook.py <<'PYTHON'
import nbformat
from nbclient import NotebookClient

cells = [nbformat.v4.new_code_cell(open("example.py").read()), nbformat.v4.new_code_cell("print(bool(run), 'still open')")]
notebook = nbformat.v4.new_notebook(cells=cells)
NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
for cell in notebook.cells:
    print("".join(output.text for output in cell.outputs if output.name == "stdout"), end="")
PYTHON
python=$(python_with 'h5py, nbclient, ipykernel')
if [ -n "$python" ]; then
    example python 'import h5py' >example.py
    try notebook '^complete 1 status 0' "$python" notebook.py
    grep -q '^True still open$' said.txt || fail "the file was closed"
else
    echo "SKIPPED: h5py, nbclient or ipykernel is not installed"
fi
if command -v pvpython >/dev/null; then
    example pvpython 'from paraview' >example.py
    try "ParaView, Xdmf 3" '^frames [1-9][0-9]* points 300$' pvpython example.py
    sed -i 's/Xdmf3ReaderS(FileName=/XDMFReader(FileNames=/' example.py
    try "ParaView, Xdmf 2" '^frames [1-9][0-9]* points 300$' pvpython example.py
else
    echo "SKIPPED: ParaView is not installed"
fi
if command -v octave-cli >/dev/null; then
    example octave 'run = load' >example.m
    try Octave '^complete 1 status 0 seed 1' octave-cli --no-gui --quiet example.m
else
    echo "SKIPPED: Octave is not installed"
fi
# Node.js looks for modules beside the script alone: those that npm installed for all are linked there.
modules=$(npm root -g 2>/dev/null)
if command -v node >/dev/null && [ -d "$modules/h5wasm" ]; then
    ln -s "$modules" node_modules
    example javascript 'import h5wasm' >example.mjs
    try h5wasm '^complete 1 status 0' node example.mjs
    grep -q '^contacts of the last frame [1-9]' said.txt || fail "h5wasm finds no contacts"
else
    echo "SKIPPED: h5wasm is not installed (npm install -g h5wasm)"
fi
[ $tried -gt 0 ] || exit 125
