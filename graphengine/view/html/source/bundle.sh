#!/bin/sh
# Makes bundle.js, uplot.js and uplot.css of the folder above from the sources in this folder and packages of npm.
# tests/view/html/test_bundle.py fails if the sources were changed without a run of this script.
set -eu
sources=$(cd "$(dirname "$0")" && pwd)
target=$(dirname "$sources")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$sources"/*.js "$sources"/package*.json "$folder"
cd "$folder"
npm ci --silent --ignore-scripts
digest=$(cat decode.js main.js package.json plots.js scene.js | sha256sum | cut -d ' ' -f 1)
{
  printf '/*! Sources: %s\nThree.js is part of this script:\n' "$digest"
  cat node_modules/three/LICENSE
  printf '*/\n'
  node_modules/.bin/esbuild main.js --bundle --minify --format=esm --target=es2022 --legal-comments=none
} > "$target/bundle.js"
{
  printf '/*!\n'
  cat node_modules/uplot/LICENSE
  printf '*/\n'
  cat node_modules/uplot/dist/uPlot.iife.min.js
} > "$target/uplot.js"
cat node_modules/uplot/dist/uPlot.min.css > "$target/uplot.css"
