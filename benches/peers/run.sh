#!/usr/bin/env bash
# Compares Surefoot with Pinocchio, Coal and OMPL: run.sh [--robot ROBOT.toml].
# Installs its Python environment on first use (PyPI).
# Exit: 0 all measured and agreed, 1 a disagreement, 2 it could not run.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
venv=${XDG_CACHE_HOME:-$HOME/.cache}/surefoot-peers/venv
stamp=$venv/$(sha256sum "$here/requirements.txt" | cut -c1-16)
if [[ ! -e $stamp ]]; then
  echo "setting the peers' environment up (once, about a minute)" >&2
  python3 -m venv "$venv" || exit 2
  "$venv/bin/pip" install -q -r "$here/requirements.txt" >&2 || exit 2
  touch "$stamp"
fi
exec "$venv/bin/python" "$here/peers.py" "$@"
