#!/usr/bin/env bash
# Draws the pictures of docs/GALLERY.md: the plan of each scenario, and one search without a plan.
# Needs `surefoot` in PATH, or SUREFOOT_PROGRAM. Without arguments it draws into docs/gallery, which
# git does not keep.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

program=${SUREFOOT_PROGRAM:-surefoot}
out=${1:-docs/gallery}
found=(flat_walk ibeam_gap ibeam_hallway beam stairs cinder_blocks stepping_stones checkers
  pass_under rough_ground spiral_steps monkey_bars jungle_gym_full jungle_gym_spiral_route
  jungle_gym_stair_route sl1m_complex stairs_bauzil gauntlet_1 gauntlet_2)
mkdir -p "$out"
for scenario in "${found[@]}"; do
  "$program" plan "$scenario" --quiet --picture "$out/$scenario.png"
done
# No plan: the picture shows how far the search came.
"$program" plan no_way_wall --quiet --picture "$out/no_way_wall.png" || [[ $? = 3 ]]
