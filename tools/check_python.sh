#!/usr/bin/env bash
# Builds the Python wheel, installs it into a new virtual environment and runs its tests. The build
# is a whole one of its own, so that it is no part of the test command. CARGO names another cargo,
# CARGO_TARGET_DIR a folder to build in, SUREFOOT_PYTHON_EXTRAS what to install beside
# ("live,view,batch,test"; about 1.2 GB), SUREFOOT_WHEEL a wheel that is built already.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

extras=${SUREFOOT_PYTHON_EXTRAS:-live,view,batch,test}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

python3 -m venv "$scratch/environment"
export PATH=$scratch/environment/bin:$PATH
wheel=${SUREFOOT_WHEEL:-}
if [[ -z $wheel ]]; then
  pip install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2'
  maturin build --release --manifest-path python/Cargo.toml --out "$scratch/wheels" "$@"
  wheel=$(ls "$scratch"/wheels/*.whl)
fi
pip install --quiet --disable-pip-version-check "$wheel[$extras]"
if [[ -z ${SUREFOOT_PROGRAM:-} && -x target/release/surefoot ]]; then
  export SUREFOOT_PROGRAM=$PWD/target/release/surefoot
fi
# From another folder, so that only the installed package is found.
root=$PWD
cd "$scratch"
python -m pytest -q -p no:cacheprovider -c "$root/python/pyproject.toml" --rootdir "$root/python" \
  "$root/python/tests"
