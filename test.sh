#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds in Release, and runs all tests except those labelled "long".
# Usage: ./test.sh [--yes]
set -euo pipefail
cd "$(dirname "$0")"

bash cmake/setup.sh tests "$@"
cmake --preset release
cmake --build --preset release
ctest --preset release
