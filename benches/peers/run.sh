#!/bin/sh
# Durometer, CalculiX, FElupe and scikit-fem on the same meshes and problem, one core. Makes a venv beside the built program.
# Usage: benches/peers/run.sh [REPEATS]      CORE=1 chooses the core
set -e
cd "$(dirname "$0")/../.."
cargo build --release
target=${CARGO_TARGET_DIR:-target}
venv=$target/peers-venv
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r benches/peers/requirements.txt
fi
export OMP_NUM_THREADS=1 MKL_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 RAYON_NUM_THREADS=1
exec taskset -c "${CORE:-0}" "$venv/bin/python" benches/peers/peers.py "$target/release/durometer" "${1:-3}"
