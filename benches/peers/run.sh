#!/bin/sh
# Durometer, CalculiX, FElupe and scikit-fem on the same meshes and problem. Makes a venv next to the built program.
# Usage: benches/peers/run.sh [REPEATS [PROGRAM ...]]      THREADS=2 for two threads on as many cores
set -e
cd "$(dirname "$0")/../.."
cargo build --release
target=${CARGO_TARGET_DIR:-target}
venv=$target/peers-venv
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r benches/peers/requirements.txt
fi
export THREADS="${THREADS:-1}"
export OMP_NUM_THREADS="$THREADS" MKL_NUM_THREADS="$THREADS" OPENBLAS_NUM_THREADS="$THREADS"
repeats="${1:-3}"
[ $# -gt 0 ] && shift
exec taskset -c "0-$((THREADS - 1))" "$venv/bin/python" benches/peers/peers.py "$(cd "$target/release" && pwd)/durometer" "$repeats" "$@"
