#!/usr/bin/env bash
# An arm64 Python with numpy, onnxruntime, Pillow and scipy, and the emulator that runs it: Debian's packages,
# unpacked into FOLDER and not installed, and wheels. Needs apt-get, dpkg and pip of a Debian or Ubuntu,
# half a gigabyte, and no root. Older emulators than this suite's crash in onnxruntime.
#
#     tests/arm/fetch.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/../.."
constraints=$PWD/constraints.txt
cd - >/dev/null
suite=trixie python=3.13
mkdir -p "$1"
folder=$(cd "$1" && pwd)
[ -e "$folder/fetched" ] && exit 0
host=$(dpkg --print-architecture)
mkdir -p "$folder"/apt/{lists,cache/archives,state}/partial "$folder"/{root,emulator,site,wheels}
touch "$folder/apt/state/status"
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian $suite main" \
    >"$folder/apt/sources.list"
cat >"$folder/apt/conf" <<EOF
Dir::Etc::SourceList "$folder/apt/sources.list";
Dir::Etc::SourceParts "-";
Dir::State "$folder/apt/state";
Dir::State::Lists "$folder/apt/lists";
Dir::State::status "$folder/apt/state/status";
Dir::Cache "$folder/apt/cache";
APT::Architectures { "$host"; "arm64"; };
APT::Sandbox::User "root";
EOF
export APT_CONFIG=$folder/apt/conf
apt-get update -qq
apt-get install -qq -y --download-only --no-install-recommends -o APT::Architecture=arm64 \
    "python$python:arm64" libstdc++6:arm64 >/dev/null
for package in "$folder"/apt/cache/archives/*.deb; do dpkg -x "$package" "$folder/root"; done
ln -sfn usr/lib "$folder/root/lib" # where programs look for their loader
(cd "$folder/apt" && apt-get download -qq "qemu-user:$host")
dpkg -x "$folder"/apt/qemu-user_*.deb "$folder/emulator"
"${PYTHON:-python3}" -m pip download -q --no-deps --only-binary=:all: --python-version "$python" \
    --platform manylinux_2_28_aarch64 --platform manylinux_2_27_aarch64 \
    --platform manylinux_2_17_aarch64 --constraint "$constraints" --dest "$folder/wheels" \
    numpy onnxruntime pillow scipy
for wheel in "$folder"/wheels/*.whl; do
    "${PYTHON:-python3}" -m zipfile -e "$wheel" "$folder/site"
done
rm -rf "$folder/apt" "$folder/wheels"
touch "$folder/fetched"
