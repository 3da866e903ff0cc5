#!/usr/bin/env bash
# Measures a built hachure on a machine with a GPU, in less than five minutes, without Rust, Python or a display. Parts,
# in this order: the first picture; all presets at 1920x1080; a flight over the continent with 512, 128 and 64 MiB for
# tiles; two eyes of 3164x3092; 3840x2160; a forest; 2560x1440; the continent at 3840x2160, and a turn and back; a tiny
# allowed error; cliffs. It writes CARD.json, which holds every report.json, and CARD.md, a table. A part that fails or
# for which no time is left is listed there; the others go on.
#
#   HACHURE=target/release/hachure benches/gpu.sh
#   HACHURE=new BASE=old benches/gpu.sh          each part is run with BASE, then with HACHURE; the table has the ratios,
#                                                and what became worse with its noise (hachure bench --compare). Two
#                                                programs take twice as long: the presets may need all the time, so
#                                                give --only continent for streaming
#
# Options:
#   --quick            fewer frames and parts, in two minutes
#   --seconds N        at most N seconds in all (290, with --quick 120): the first parts that fit are run
#   --only WORDS       only parts whose names contain one of these words, separated by commas
#   --out FOLDER       where the two files are written (benches/reports, if the script is in its repository, else .)
#   --name NAME        their name (that of the card)
#
# Environment:
#   HACHURE, BASE      the program [target/release/hachure of this repository], and an older one to compare it with
#   ADAPTER            for hachure --adapter: software, or a part of the card's name
#   SCALE              percent of the sizes of pictures, to test the script on a slow machine (100)
#   GROUP              presets in one process (9): each has its own renderer and terrain, which take 0.2 to 0.6 GB of GPU
#                      memory, and up to 1.5 GB with rows of hachures; give fewer on a small card
#   STYLES             presets of the first part, separated by commas (all)
#
# Styles of one process take turns at every frame, so ratios between them are fair (docs/decisions/timing.md).
set -u
export LC_ALL=C

quick=0 seconds="" only="" out="" name=""
while [ $# -gt 0 ]; do
    case "$1" in
    --quick) quick=1 ;;
    --seconds | --only | --out | --name)
        [ $# -gt 1 ] || { echo "gpu.sh: $1 needs a value" >&2; exit 2; }
        case "$1" in --seconds) seconds="$2" ;; --only) only="$2" ;; --out) out="$2" ;; --name) name="$2" ;; esac
        shift ;;
    -h | --help) sed -n '2,/^set -u/{/^#/s/^# \{0,1\}//p;}' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "gpu.sh: unknown option $1 (--help lists them)" >&2; exit 2 ;;
    esac
    shift
done
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
HACHURE="${HACHURE:-$here/../target/release/hachure}"
BASE="${BASE:-}"
SCALE="${SCALE:-100}"
GROUP="${GROUP:-9}"
for number in "$SCALE" "$GROUP" "${seconds:-1}"; do
    case "$number" in '' | *[!0-9]* | 0) echo "gpu.sh: $number is not a whole number above 0" >&2; exit 2 ;; esac
done
for program in "$HACHURE" ${BASE:+"$BASE"}; do
    [ -x "$program" ] || { echo "gpu.sh: $program is not a program: set HACHURE (and BASE) to built programs" >&2; exit 2; }
done
if [ $quick = 1 ]; then seconds="${seconds:-120}"; else seconds="${seconds:-290}"; fi
if [ -z "$out" ]; then out=.; [ -f "$here/../Cargo.toml" ] && out="$here/reports"; fi
mkdir -p "$out" || exit 1

work="$(mktemp -d)" || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
# Nothing that an earlier run has cached makes this one faster.
export __GL_SHADER_DISK_CACHE_PATH="$work/driver" MESA_SHADER_CACHE_DIR="$work/driver" MESA_GLSL_CACHE_DIR="$work/driver"
mkdir -p "$work/driver"
SECONDS=0

# size WIDTH HEIGHT: the size of a picture, scaled.
size() {
    local w=$(($1 * SCALE / 100)) h=$(($2 * SCALE / 100))
    echo "$((w < 16 ? 16 : w))x$((h < 16 ? 16 : h))"
}

# limited LIMIT COMMAND...: runs a command for at most LIMIT seconds; returns 124 if it was ended.
limited() {
    local limit="$1" pid watch status
    shift
    if command -v timeout >/dev/null; then
        timeout -k 5 "$limit" "$@"
        return
    fi
    "$@" &
    pid=$!
    (sleep "$limit"; kill "$pid") >/dev/null 2>&1 &
    watch=$!
    wait "$pid"
    status=$?
    kill "$watch" 2>/dev/null
    [ $status = 143 ] && status=124
    return $status
}

# quoted TEXT: a JSON string.
quoted() {
    printf '"%s"' "$(printf '%s' "$1" | tr '\n\t\r' '   ' | sed 's/\\/\\\\/g; s/"/\\"/g')"
}

# Prints the leaves of a report.json as lines "path value", with a path such as runs.0.frame_ms.p50. It relies on the
# file's layout: one key a line, and two more spaces at each level.
flat() {
    awk '
        { indent = match($0, /[^ ]/) - 1; depth = indent / 2; text = substr($0, indent + 1); sub(/,$/, "", text) }
        text ~ /^[\]}]/ { next }
        {
            if (match(text, /^"[^"]*": /)) { key[depth] = substr(text, 2, RLENGTH - 4); text = substr(text, RLENGTH + 1) }
            else key[depth] = depth > 0 ? count[depth]++ : ""
            if (text ~ /^[\[{]$/) { count[depth + 1] = 0; next }
            gsub(/^"|"$/, "", text)
            path = key[1]
            for (level = 2; level <= depth; level++) path = path "." key[level]
            print path " " text
        }' "$1"
}

parts=0
# The JSON objects of the parts and the lines of the table, in files, since shells are slow with long strings.
: >"$work/parts.json"
: >"$work/rows"
: >"$work/missing"

is_wanted() {
    local word
    [ -z "$only" ] && return 0
    for word in ${only//,/ }; do case "$1" in *"$word"*) return 0 ;; esac; done
    return 1
}

# note PART PROGRAM STATUS SECONDS ARGUMENTS [REPORT]: adds a part to both files.
note() {
    [ $parts -gt 0 ] && echo , >>"$work/parts.json"
    parts=$((parts + 1))
    {
        printf '{"part": %s, "program": "%s", "status": %s, "seconds": %s, "arguments": %s, "report": ' \
            "$(quoted "$1")" "$2" "$(quoted "$3")" "$4" "$(quoted "$5")"
        if [ -n "${6:-}" ]; then sed 's/^ *//' "$6" | tr -d '\n'; else printf null; fi
        printf '}'
    } >>"$work/parts.json"
    if [ -n "${6:-}" ]; then
        echo "$1|$2|arguments ${5//"$work/"/}" >>"$work/rows"
        flat "$6" | sed "s/^/$1|$2|/" >>"$work/rows"
    fi
    if [ "$3" != ok ]; then
        printf -- '- %s, %s: %s\n' "$1" "$2" "$3" >>"$work/missing"
        echo "  $2: $3" >&2
    fi
}

# run_one PART PROGRAM ARGUMENTS...: runs `hachure bench` once.
run_one() {
    local part="$1" which="$2" program="$HACHURE" left=$((seconds - SECONDS)) begun=$SECONDS report="" compare=""
    shift 2
    [ "$which" = base ] && program="$BASE"
    [ "$which" = new ] && [ -n "$can_compare" ] && compare="$work/report-base/report.json"
    [ -f "$compare" ] || compare=""
    if [ $left -lt 5 ]; then
        note "$part" "$which" "no time left" 0 "$*"
        return
    fi
    rm -rf "$work/report-$which"
    # Programs before --steadiness-pairs call it --temporal, and all know that name.
    HACHURE_CACHE="$work/cache-$which" limited "$left" "$program" bench ${ADAPTER:+--adapter "$ADAPTER"} "$@" \
        --temporal 0 ${compare:+--compare "$compare"} -o "$work/report-$which" >"$work/text" 2>"$work/errors"
    local status=$?
    case $status in
    0) status=ok report="$work/report-$which/report.json" ;;
    124) status="took longer than the $left s that were left" ;;
    *) status="status $status: $(tail -n 1 "$work/errors")" ;;
    esac
    note "$part" "$which" "$status" $((SECONDS - begun)) "$*" "$report"
}

# part NAME ARGUMENTS...: runs a part with each program.
programs=new
[ -n "$BASE" ] && programs="base new"
can_compare="$("$HACHURE" bench --help 2>/dev/null | grep -e --compare)"
part() {
    local which
    is_wanted "$1" || return 0
    echo "$1 (at $SECONDS s)" >&2
    rm -rf "$work/report-base"
    for which in $programs; do run_one "$1" "$which" "${@:2}"; done
}

# first_pictures PROGRAM: the time to the first picture, with empty caches, then with full ones; the world is baked.
first_pictures() {
    local program="$HACHURE" which="$1" state left
    [ "$which" = base ] && program="$BASE"
    export HACHURE_CACHE="$work/cache-$which"
    if ! limited "$seconds" "$program" render ${ADAPTER:+--adapter "$ADAPTER"} --style plain --size 64x64 \
        -o "$work/baked.png" --overwrite >/dev/null 2>"$work/errors"; then
        note "first picture" "$which" "baking the world failed: $(tail -n 1 "$work/errors")" "$SECONDS" ""
        return
    fi
    rm -rf "$HACHURE_CACHE/pipelines" "$work/driver"
    mkdir -p "$work/driver"
    for state in cold warm; do
        left=$((seconds - SECONDS))
        if TIMEFORMAT='%R %U'; { time limited "$((left < 5 ? 5 : left))" "$program" render \
            ${ADAPTER:+--adapter "$ADAPTER"} --style ink --size "$(size 1920 1080)" -o "$work/first.png" --overwrite \
            >/dev/null 2>"$work/errors"; } 2>"$work/time"; then
            echo "first picture|$which|$state $(cat "$work/time")" >>"$work/rows"
            note "first picture, $state" "$which" ok "$(cut -d' ' -f1 "$work/time")" "render --style ink"
        else
            note "first picture, $state" "$which" "$(tail -n 1 "$work/errors")" 0 "render --style ink"
        fi
    done
    unset HACHURE_CACHE
}

# The first 9 s of terrain/paths/valley.csv: 300 m/s along a valley of the continent.
cat >"$work/valley.csv" <<'PATH_END'
t,x,y,z,yaw,pitch,fov
0,5640,-8920,1938,-43.5,-0.7,58
1.5,5330,-8593,1988,-43.4,1.6,58
3,5022,-8266,2055,-43.3,2.4,58
4.5,4712,-7939,2139,-44.1,3.7,58
6,4395,-7620,2183,-46.7,-2.6,58
7.5,4058,-7323,2184,-52.0,-3.0,58
9,3687,-7069,2184,-60.5,-3.0,58
PATH_END
head -n 5 "$work/valley.csv" >"$work/short.csv"
# On the spot: a turn by 180 degrees in two seconds, and back.
cat >"$work/turn.csv" <<'PATH_END'
t,x,y,z,yaw,pitch,fov
0,5640,-8920,1938,-43.5,-0.7,58
1,5640,-8920,1938,-43.5,-0.7,58
3,5640,-8920,1938,136.5,-0.7,58
4,5640,-8920,1938,136.5,-0.7,58
6,5640,-8920,1938,316.5,-0.7,58
PATH_END
# Terraces with walls of 300 m from one sample to the next, 2 m apart.
awk 'BEGIN {
    print "ncols 257\nnrows 257\nxllcorner 0\nyllcorner 0\ncellsize 2"
    for (y = 0; y < 257; y++) {
        line = ""
        for (x = 0; x < 257; x++) line = line (300 * int((x + 2 * y + 20 * sin(x / 9)) / 130) + (x * y) % 7) " "
        print line
    }
}' >"$work/cliffs.asc"
cat >"$work/cliffs.csv" <<'PATH_END'
t,x,y,z,yaw,pitch,fov
0,-250,-320,+120,30,-8,60
4,-120,-150,+60,80,-4,60
PATH_END

frames=40 flight=valley
if [ $quick = 1 ]; then frames=12 flight=short; fi
[ -n "$BASE" ] && { frames=$((frames / 2)); flight=short; }
full="$(size 1920 1080)"
styles="${STYLES:-$("$HACHURE" styles 2>/dev/null | awk '{ printf "%s%s", sep, $1; sep = "," }')}"

if is_wanted "first picture"; then
    echo "first picture" >&2
    for program in $programs; do first_pictures "$program"; done
fi

group=0
for list in $(echo "$styles" | tr ',' '\n' | awk -v n="$GROUP" '{ printf "%s%s", (NR % n == 1 || n == 1) ? (NR > 1 ? "\n" : "") : ",", $1 } END { print "" }'); do
    group=$((group + 1))
    part "presets $group" --path tour --frames "$frames" --size "$full" --styles "$list" --tile-memory 128
done
for mebibytes in 512 128 64; do
    part "continent, $mebibytes MiB" continent --path "$work/$flight.csv" --real-time --size "$full" --styles ink \
        --tile-memory $mebibytes
done
few=$((frames / 2))
part "two eyes of 3164x3092" --path tour --frames $few --size "$(size 3164 3092)" --eyes side-by-side \
    --styles plain,ink,pen,strokes,crosshatch --tile-memory 128
part "4K" --path tour --frames $few --size "$(size 3840 2160)" --styles plain,ink,strokes,hachures --tile-memory 128
part "forest" forest --path tour --frames $few --size "$full" --styles ink,strokes,pencil
if [ $quick = 0 ]; then
    part "1440p" --path tour --frames $few --size "$(size 2560 1440)" --styles plain,ink,strokes,hachures --tile-memory 128
    part "continent 4K, 128 MiB" continent --path "$work/short.csv" --real-time --size "$(size 3840 2160)" --styles ink \
        --tile-memory 128
    part "continent, turn and back, 128 MiB" continent --path "$work/turn.csv" --real-time --size "$full" --styles ink \
        --tile-memory 128
fi
part "allowed error of 0.1 px" --path tour --frames $few --size "$full" --styles plain,hachures --lod-error 0.1
part "cliffs" "$work/cliffs.asc" --path "$work/cliffs.csv" --frames $few --size "$full" --styles ink,strokes,hachures,relief
took=$SECONDS

adapter="$(sed -n 's/^[^|]*|[^|]*|adapter //p' "$work/rows" | head -n 1)"
adapter="${adapter:-unknown GPU}"
cpu="$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)"
[ -n "$cpu" ] || cpu="$(sysctl -n machdep.cpu.brand_string 2>/dev/null || uname -m)"
cores="$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo null)"
smi="$(command -v nvidia-smi >/dev/null && nvidia-smi --query-gpu=name,driver_version,memory.total --format=csv,noheader 2>/dev/null | head -n 1)"
# version PROGRAM: its version, and a checksum that tells builds of one version apart.
version() {
    echo "$("$1" --version 2>/dev/null) (cksum $(cksum <"$1" | cut -d' ' -f1))"
}
versions="$(version "$HACHURE")"
[ -n "$BASE" ] && versions="$versions; base: $(version "$BASE")"
options="--seconds $seconds$([ $quick = 1 ] && echo " --quick")${only:+ --only $only}, GROUP=$GROUP"
if [ -z "$name" ]; then
    name="$(echo "${adapter%%(*}" | tr 'A-Z' 'a-z' | sed 's/[^a-z0-9]\{1,\}/-/g; s/^-//; s/-$//')"
fi

{
    printf '{"adapter": %s, "nvidia_smi": %s, "cpu": %s, "cores": %s, "system": %s, "date": "%s", "programs": %s,\n' \
        "$(quoted "$adapter")" "$(quoted "$smi")" "$(quoted "$cpu")" "$cores" "$(quoted "$(uname -srm)")" \
        "$(date -u +%Y-%m-%dT%H:%M:%SZ)" "$(quoted "$versions")"
    printf '"seconds": %s, "scale_percent": %s, "parts": [\n' "$took" "$SCALE"
    cat "$work/parts.json"
    printf '\n]}\n'
} >"$work/all.json"

{
    echo "# $adapter"
    echo
    echo "$cpu, $cores cores; $(uname -srm); $(date -u +%Y-%m-%d); $versions${smi:+; nvidia-smi: $smi}; $options; $took s."
    [ "$SCALE" = 100 ] || printf '\n**Pictures have %s %% of the sizes that the parts name.**\n' "$SCALE"
    echo
    echo "Made by \`benches/gpu.sh\`. Times are milliseconds: medians and 99th percentiles over the frames. *Frame* is by"
    echo "the CPU's clock from the beginning of a frame until the GPU has finished it, with a timer around each pass;"
    echo "*latency* is the same without timers, and *throughput* the time from one frame to the next with two frames in"
    echo "flight. *GPU* is the time of frames with timers that follow each other without a pause (programs that do not"
    echo "measure this report frames of the flight, when a GPU that waits has low clocks). *Prepare* chooses tiles and patches;"
    echo "*record* and *submit* make the commands. *wgpu passes* are compute and render passes of the API: dispatches that follow"
    echo "each other share one. *Barriers*: how often work waits for earlier work of the frame. *GB* are what the passes of one frame declare to read and write, each resource once"
    echo "for a named pass (a shader with all its runs): of the traced frames, those of the frame that moved most bytes."
    echo "*Late*: frames with tiles missing. *Loaded* and *evicted*: tiles, during the flight. A dash means not measured."
    if [ -n "$BASE" ]; then
        echo
        echo "*Ratios* are of medians, new ÷ base. The lists compare the frames of both programs one by one (\`by pairs\`,"
        echo "± two standard errors)."
    fi
    if grep -q '^first picture|' "$work/rows"; then
        printf '\n## First picture\n\nSeconds until `render --style ink --size %s` has ended; the world is baked.\n\n' "$full"
        echo "| program | caches | s | CPU s |"
        echo "| --- | --- | ---: | ---: |"
        sed -n 's/^first picture|\([a-z]*\)|\([a-z]*\) \([0-9.]*\) \([0-9.]*\)/| \1 | \2 | \3 | \4 |/p' "$work/rows"
    fi
    awk -F'|' -v both="${BASE:+1}" '
        function number(value, decimals) {
            return value == "" || value == "null" ? "–" : sprintf("%." decimals "f", value)
        }
        # A change from old to new: of bytes in MB, with its percentage and, if it has one, its noise.
        function shown(figure, old, new, ratio, noise,   unit, text) {
            unit = figure ~ /bytes/ ? 1e6 : 1
            text = unit > 1 ? sprintf("%.1f to %.1f MB", old / unit, new / unit) : sprintf("%.5g to %.5g", old, new)
            if (ratio == "null") return text
            if (noise == "null") return text sprintf(" (%+.1f %%)", (ratio - 1) * 100)
            return text sprintf(" (%+.1f %% ± %.1f by pairs)", (ratio - 1) * 100, 200 * noise * ratio)
        }
        function of(key) { return value[at SUBSEP key] }
        function gigabytes(bytes) { return number(bytes == "" ? "" : bytes / 1e9, 3) }
        function pick(first, second) { return first != "" ? first : second }
        function ratio(program, key) {
            old = value["base" SUBSEP program SUBSEP key]; new = value["new" SUBSEP program SUBSEP key]
            return old + 0 > 0 && new != "" ? sprintf("%.2f", new / old) : "–"
        }
        function flush(   run, i, n, program) {
            if (part == "") return
            printf "\n## %s\n\n`%s`\n\n", part, arguments
            print "| style |" (both ? " program |" : "") " frame p50 | p99 | GPU p50 | p99 | latency | throughput | prepare p50 | p99 | record | submit | wgpu passes | dispatches | barriers | GB read | GB written | triangles | late | loaded | evicted |" (both ? " frame ratio | GPU ratio |" : "")
            line = "| --- |" (both ? " --- |" : "")
            for (i = 0; i < 19 + (both ? 2 : 0); i++) line = line " ---: |"
            print line
            for (run = 0; run < runs; run++) for (n = 1; n <= 2; n++) {
                program = n == 1 ? "base" : "new"
                at = program SUBSEP run
                if (of("style") == "") continue
                # Older programs call it passes; still older ones have no work, only the bytes of each pass.
                passes = pick(of("work.wgpu_passes"), of("work.passes"))
                bytes_read = pick(of("work.bytes_read"), read[at]); bytes_written = pick(of("work.bytes_written"), written[at])
                print "| " of("style") " |" (both ? " " program " |" : "") \
                    " " number(of("frame_ms.p50"), 2) " | " number(of("frame_ms.p99"), 2) \
                    " | " number(pick(of("busy.gpu_ms.p50"), of("gpu_ms.p50")), 3) \
                    " | " number(pick(of("busy.gpu_ms.p99"), of("gpu_ms.p99")), 3) \
                    " | " number(of("untimed.latency_ms.p50"), 2) " | " number(of("untimed.throughput_ms"), 2) \
                    " | " number(of("prepare_ms.p50"), 3) " | " number(of("prepare_ms.p99"), 3) \
                    " | " number(of("untimed.record_ms"), 3) " | " number(of("untimed.submit_ms"), 3) \
                    " | " number(passes, 0) " | " number(of("work.dispatches"), 0) " | " number(of("work.barriers"), 0) \
                    " | " gigabytes(bytes_read) " | " gigabytes(bytes_written) \
                    " | " number(of("triangles"), 0) " | " number(of("tiles.late_frames"), 0) \
                    " | " number(of("tiles.loaded"), 0) " | " number(of("tiles.evicted"), 0) " |" \
                    (both ? (n == 1 ? " | |" : " " ratio(run, "frame_ms.p50") " | " ratio(run, "gpu_ms.p50") " |") : "")
            }
            for (n = 0; n < notes; n++) printf "%s- note: %s\n", n ? "" : "\n", noted[n]
            notes = 0
            for (n = 0; n < changes; n++) printf "%s%s\n", n ? "" : "\n", change[n]
            changes = 0
            split("", value); split("", read); split("", written); runs = 0
        }
        $1 == "first picture" { next }
        $1 != part { flush(); part = $1 }
        {
            path = $3; text = path; sub(/ .*/, "", path); sub(/^[^ ]* /, "", text)
            if (path ~ /^comparison\.(worse|better)\./) {
                key = path; sub(/.*\./, "", key); found[key] = text
                # The last key of a change.
                # The figures of single passes are in the JSON.
                if (key == "noise" && found["figure"] !~ / of /) {
                    split(path, words, ".")
                    change[changes++] = sprintf("- %s: %s, %s: %s", words[2], found["style"], found["figure"], \
                        shown(found["figure"], found["old"], found["new"], found["ratio"], text))
                }
                next
            }
            if (path ~ /^comparison\.notes\./) noted[notes++] = text
            if (path == "arguments") arguments = text
            if (path !~ /^runs\./) next
            sub(/^runs\./, "", path)
            run = path; sub(/\..*/, "", run); key = path; sub(/^[0-9]*\./, "", key)
            if (run + 1 > runs) runs = run + 1
            at = $2 SUBSEP run
            if (key ~ /^passes\..*\.bytes_read$/ && text != "null") read[at] += text
            else if (key ~ /^passes\..*\.bytes_written$/ && text != "null") written[at] += text
            value[at, key] = text
        }
        END { flush() }' "$work/rows"
    if [ -s "$work/missing" ]; then
        printf '\n## Not measured\n\n'
        cat "$work/missing"
    fi
} >"$work/all.md"

cp "$work/all.json" "$out/$name.json" && cp "$work/all.md" "$out/$name.md" || exit 1
cat "$work/all.md"
echo "$out/$name.json" >&2
