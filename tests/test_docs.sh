#!/usr/bin/env bash
# What the documentation says about the code. Usage: test_docs.sh reference|channels|links|history|commands|guards FOLDER SIM
set -uo pipefail

failures=0

complain() {
    printf '%s\n' "$*"
    failures=$((failures + 1))
}

same() { # WHAT EXPECTED GOT
    [ "$2" = "$3" ] || complain "$1:" $'\n'"$(diff <(echo "$2") <(echo "$3"))"
}

reference() { # FOLDER
    "$sim" --reference | diff "$1/docs/scene-reference.md" - ||
        complain "docs/scene-reference.md is not what sim --reference prints: ./shakedown docs"
}

recorded_channels() { # FOLDER: those of the record stream, in order
    sed -n '/^#define RECORD_CHANNEL_LIST/,/[^\\]$/s/^ *X(\([A-Z_]*\)).*/\1/p' "$1/common/bus.h"
}

channels_in_code() { # FOLDER
    recorded_channels "$1"
    sed -n 's/^#define CHANNEL_[A-Z_]* *"\([A-Z_]*\)"$/\1/p' "$1/common/bus.h"
}

# Rows of the table: | `CHANNEL` | `type` | ...
rows_in_table() { # FOLDER COLUMN
    sed -n 's/^| `\([A-Z_]*\)` | `\([a-z_]*\)` |.*/\1 \2/p' "$1/lcmtypes/CHANNELS.md" | cut -d' ' -f"$2"
}

channels() { # FOLDER
    local file types=()
    [ "$(channels_in_code "$1" | wc -l)" -ge 10 ] || complain "common/bus.h: channels were not found"
    same "channels, code against table" "$(channels_in_code "$1" | sort)" "$(rows_in_table "$1" 1 | sort)"
    for file in "$1"/lcmtypes/*.lcm; do
        types+=("$(basename "$file" .lcm)")
    done
    same "types, lcmtypes/ against table" "$(printf '%s\n' "${types[@]}" | sort)" "$(rows_in_table "$1" 2 | sort)"
    same "order of the record stream" "$(recorded_channels "$1" | paste -sd' ')" \
        "$(sed -n 's/.*recorded channels `\([A-Z_ ]*\)`.*/\1/p' "$1/lcmtypes/CHANNELS.md")"
}

pages() { # FOLDER: every page, or the one of `only_page`
    [ -z "${only_page:-}" ] || { echo "$1/$only_page" && return; }
    (cd "$1" && find . -name '*.md' -not -path './build*' -not -path './runs/*' -not -path '*/.*') | sed "s:^\.:$1:"
}

# GitHub's names of the headings of a file.
anchors() { # FILE
    sed -n 's/^##* *//p' "$1" | tr '[:upper:]' '[:lower:]' | sed 's/[^[:alnum:] _-]//g; s/ /-/g'
}

link_check() { # FROM LINK
    local path=${2%%#*} target
    case $2 in http://* | https://*) return ;; esac
    target=$1
    [ -z "$path" ] || target=$(dirname "$1")/$path
    if [ ! -e "$target" ]; then
        complain "$1: $2 is not there"
    elif [[ $2 == *'#'* ]] && ! anchors "$target" | grep -qxF -- "${2#*#}"; then
        complain "$1: $2: no such heading"
    fi
}

links() { # FOLDER
    local file link count=0
    while read -r file; do
        while read -r link; do
            link_check "$file" "$link"
            count=$((count + 1))
        done < <(sed 's/`[^`]*`//g' "$file" | grep -oE ']\([^) ]*\)|src="[^"]*"' | sed 's/^](//; s/^src="//; s/[)"]$//')
    done < <(pages "$1")
    [ "$count" -gt 0 ] || complain "no link was found"
}

# Pages say what is, not how it came about: no commits, and no words that compare with what the reader never saw.
history() { # FOLDER
    local words='commits? [0-9a-f]{7}|(earlier|former|previous|first|new|old) (kernels?|versions?|builds?|designs?|tables?)'
    words+='|(version|build|commit)s? before|no longer|any ?more|formerly|previously|used to be|until now|today|yesterday'
    words+='|recently|\(before|before:|now|was [0-9]'
    local file hits
    while read -r file; do
        hits=$(grep -nEiw -- "$words" "$file" | cut -c1-160)
        hits+=$(grep -nowE '[0-9a-f]{7,40}' "$file" | grep -E '[0-9].*[a-f]|:[a-f].*[0-9]' | grep -vE ':[0-9]+e[0-9]+$')
        [ -z "$hits" ] || complain "$file tells history:" $'\n'"$hits"
    done < <(pages "$1")
}

readonly folders='common|lcmtypes|sim|wallctl|recorder|analyzer|launcher|scenes|tests|bench|studies|docs|examples|findings'

# Code of a page that names commands or files, one piece a line: indented and fenced lines, and what stands in backticks.
code() { # FILE
    {
        sed -n 's/^    *\([^ |-].*\)/\1/p' "$1"
        sed -n '/^```/,/^```/p' "$1"
        grep -o '`[^`]*`' "$1" | tr -d '`'
    } | grep -E "\./shakedown |(^|[ \"=(/])($folders)/|\.[ch]\$" | sort -u
}

# Options of `./shakedown COMMAND [NAME]` are in the script that reads them.
options_check() { # PAGE LINE SCRIPT...
    local option
    while read -r option; do
        grep -qrF -e "$option" "${@:3}" || complain "$1: $2: no option $option in ${*:3}"
    done < <(grep -oE -- '(^|[ []|=)--[a-z][a-z-]*' <<<"$2" | grep -oE -- '--[a-z-]*')
}

command_check() { # FOLDER PAGE LINE
    local command name scripts=("$1/shakedown" "$1/launcher")
    read -r command name _ <<<"${3#*./shakedown }"
    name=${name%%[],;)]*}
    case $command in
        [A-Z]* | '') return ;;
        bench) scripts=("$1/bench/$name.sh") ;;
        study) scripts+=("$1/studies") ;;
        *) grep -qE "^(cmd|help)_$command\(\)" "$1/shakedown" || complain "$2: $3: no command $command" ;;
    esac
    case $command-$name in
        bench-[A-Z]* | study-[A-Z]* | study-*.cfg | bench- | study-) return ;;
        bench-*) [ -f "${scripts[0]}" ] || { complain "$2: $3: no bench/$name.sh" && return; } ;;
        study-*) [ -n "$(compgen -G "$1/studies/$name*")" ] || complain "$2: $3: no studies/$name" ;;
    esac
    options_check "$2" "$3" "${scripts[@]}"
}

# Files of the project that code names, a source also by its name alone; a word with a capital, star or brace stands for
# others.
files_check() { # FOLDER PAGE LINE
    local path stands_for_others='[*{A-Z…]'
    if [[ $3 =~ ^[a-z0-9_]+\.[ch]$ ]]; then
        [ -n "$(find -L "$1"/{common,sim,wallctl,recorder,analyzer,launcher,bench,tests} -name "$3")" ] ||
            complain "$2: there is no $3"
    fi
    while read -r path; do
        [[ ! $path =~ $stands_for_others ]] || continue
        path=${path%[.,:;]}
        [ -e "$1/$path" ] || complain "$2: $path is not there"
    done < <(grep -oE '(^|[ "=(])(\./)?('"$folders"')/[^] ,;")]+' <<<"$3" |
         sed 's:^[ "=(]*::; s:^\./::')
}

commands() { # FOLDER
    local file line count=0
    while read -r file; do
        while read -r line; do
            files_check "$1" "$file" "$line"
            [[ $line != *./shakedown\ * ]] || command_check "$1" "$file" "${line%%  *}"
            count=$((count + 1))
        done < <(code "$file")
    done < <(pages "$1")
    [ "$count" -gt 0 ] || complain "no command and no file was found"
}

passes() { # CHECK FOLDER
    (failures=0; "$1" "$2" >/dev/null; [ "$failures" -eq 0 ])
}

# The check must pass on a copy, and no longer once that is damaged.
damage() { # CHECK FILE SED-EXPRESSION
    local copy=$work/copy only_page=
    case $1 in links | history | commands) only_page=$2 ;; esac
    rm -rf "$copy"
    mkdir "$copy"
    ln -s "$root"/* "$copy"
    rm "$copy"/{docs,lcmtypes,common,README.md}
    cp -r "$root"/{docs,lcmtypes,common,README.md} "$copy"
    passes "$1" "$copy" || complain "the check '$1' fails on an undamaged copy"
    sed -i "$3" "$copy/$2"
    cmp -s "$root/$2" "$copy/$2" && complain "nothing to damage in $2: $3"
    passes "$1" "$copy" && complain "the check '$1' did not find, in $2: $3"
}

guards() { # FOLDER
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    damage reference docs/scene-reference.md '/mu_s/d'
    damage channels lcmtypes/CHANNELS.md '/^| `STATUS`/d'
    damage channels lcmtypes/CHANNELS.md 's/`end_t`/`finish_t`/'
    damage channels lcmtypes/CHANNELS.md 's/`RUN_INFO PARTICLES/`PARTICLES RUN_INFO/'
    damage channels common/bus.h '/^ *X(PARTICLES)/d'
    damage channels common/bus.h 's/"STATUS"/"STATE"/'
    damage links docs/design.md 's/(theory.md)/(theories.md)/'
    damage links docs/design.md 's/(theory.md)/(theory.md#no-such-heading)/'
    damage links README.md 's/biaxial_stress.png/biaxial_strain.png/'
    damage history docs/design.md '$a The kernels are faster than those of the version before.'
    damage history docs/design.md '$a Measured with 4c7ae22.'
    damage history docs/design.md '$a A step takes 10 µs now.'
    damage commands README.md 's:shakedown run scenes/biaxial.cfg:shakedown start scenes/biaxial.cfg:'
    damage commands README.md 's:scenes/biaxial.cfg:scenes/biaxal.cfg:'
    damage commands docs/design.md 's:threads.c:thread.c:'
    damage commands docs/design.md 's:contact_law_tmpl.h:law_tmpl.h:'
    damage commands docs/peers.md 's:shakedown bench peers:shakedown bench rivals:'
    damage commands docs/peers.md 's:--reps:--turns:'
}

[ $# -eq 3 ] || { echo "usage: test_docs.sh CHECK FOLDER SIM" >&2; exit 2; }
root=$2 sim=$3
"$1" "$root"
[ "$failures" -eq 0 ]
