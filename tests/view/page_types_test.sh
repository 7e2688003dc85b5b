#!/usr/bin/env bash
# page_types_test.sh WEB WORK NPM: the pages' scripts pass TypeScript's checks, which bundling them does not make.  Exit 77 (skipped) where
# the compiler is not there and cannot be fetched.
set -euo pipefail
web=$1 work=$2 npm=$3
if [ ! -x "$npm" ]; then exit 77; fi
mkdir -p "$work"
rm -rf "$work/src"
cp -r "$web"/{package.json,package-lock.json,tsconfig.json,src} "$work"
cd "$work"
wanted=$(sha256sum <package-lock.json)
if [ "$(cat installed 2>/dev/null)" != "$wanted" ]; then
  "$npm" ci --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error || exit 77
  echo "$wanted" >installed
fi
node_modules/.bin/tsc --noEmit
