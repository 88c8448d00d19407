# shellcheck shell=bash
# What scripts/run and scripts/test share. Sourced by bash, from the root of the repository, with
# log_dir set to the folder for the output of the stages.

export LC_ALL=C.UTF-8
# A python3 of another make (pyenv, conda) that comes first on PATH knows nothing of ROS.
export PATH=/usr/bin:/usr/sbin:/bin:/sbin:$PATH
export ROS_MASTER_URI=${ROS_MASTER_URI:-http://localhost:11311}

die() {
  printf '%s\n' "$*" >&2
  exit 1
}

# ROS's own setup files read variables that are not set.
source_setup() {
  set +u
  # shellcheck disable=SC1090  # made by the build
  . "$1"
  set -u
}

# run_stage NAME COMMAND...: one line with the name, the result and the seconds; leaves the status in
# stage_status. The output goes to a log file; what matters of it is shown if the command fails.
# Never call this in a condition: bash would go on after an error inside COMMAND, a function.
run_stage() {
  local name=$1 start
  local log=$log_dir/${name//[^a-zA-Z0-9]/_}.log
  shift
  mkdir -p "$log_dir"
  printf '%-46s' "$name"
  start=$EPOCHREALTIME
  set +e
  (set -e; "$@") >"$log" 2>&1 </dev/null
  stage_status=$?
  set -e
  if ((stage_status == 0)); then
    printf '%-8s%8s s\n' ok "$(elapsed_since "$start")"
  else
    printf '%-8s%8s s\n' FAILED "$(elapsed_since "$start")"
    # Without the progress of make, of cmake and of tests that passed.
    sed -E '/^\[ *[0-9]+%\]|^-- |^\[ RUN  |^\[       OK |^\[-----|^$/d; s/^/    /' "$log" | tail -n 200
    printf '    (status %d; all output in %s)\n' "$stage_status" "$log"
  fi
}

# A stage without which nothing else makes sense.
stage() {
  run_stage "$@"
  ((stage_status == 0)) || exit 1
}

elapsed_since() {
  local microseconds=$((${EPOCHREALTIME/./} - ${1/./}))
  printf '%d.%d' $((microseconds / 1000000)) $((microseconds / 100000 % 10))
}

# configure_and_build FOLDER TARGETS CMAKE_OPTION...; several targets in one word
configure_and_build() {
  local folder=$1 targets
  read -ra targets <<<"$2"
  shift 2
  # A build folder that came along with a copied or moved clone points elsewhere.
  if [[ -f $folder/CMakeCache.txt ]] &&
    ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$folder/CMakeCache.txt"; then
    rm -rf "$folder"
  fi
  cmake -S . -B "$folder" -DPYTHON_EXECUTABLE=/usr/bin/python3 "$@"
  cmake --build "$folder" --parallel "$(nproc)" --target "${targets[@]}"
}

# The build that scripts/run starts and that users source. Its devel folder lies beside build/, not in
# it: rosrun overlooks what is in a folder build of the package.
build_node() {
  stage "build" configure_and_build build/run all -DCATKIN_DEVEL_PREFIX="$PWD/devel"
  source_setup devel/setup.bash
}
