#!/usr/bin/env bash
# Renders the manual's own pictures: make_pictures.sh [EMBERLINE]. Takes a few minutes on two cores.
# Needs oiiotool and img2webp (Debian: openimageio-tools, webp).
set -euo pipefail
cd "$(dirname "$0")"
emberline=$(realpath "${1:-../../../build/release/bin/emberline}")
scenes=$(realpath ../../../scenes)
out=$PWD/pictures
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Extracts the edits file look.json, an example in edits.md.
sed -n '/file: look.json/,/^```$/p' edits.md | grep -v -e '^```' -e '^<!--' >"$work/look.json"
cd "$work"

render() { "$emberline" render "$scenes/$1.glb" -q --size 320x180 "${@:2}"; }
join() { # arguments: NAME COLUMNSxROWS PICTURE...
  oiiotool "${@:3}" --mosaic:pad=4 "$2" --eraseattrib ".*" --nosoftwareattrib --attrib oiio:ColorSpace sRGB \
    --compression jpeg:85 -d uint8 -o "$out/$1.jpg"
}

render teapot --env "$scenes/studio.hdr" --spp 24 --denoise -o file.png
render teapot --env "$scenes/studio.hdr" --spp 24 --denoise --edits look.json -o edited.png
join edits 2x1 file.png edited.png

render moving_blade --spp 32 --denoise -o rest.png
render moving_blade --spp 64 --denoise --time 0 --shutter 0,0.5 -o moving.png
join blade 2x1 rest.png moving.png

render spheres --driver adaptive --noise-threshold 0.03 --max-spp 256 -o spheres.png --heatmap samples.png \
  --colors viridis --plain
join samples 2x1 spheres.png samples.png

render spheres --size 480x270 --spp 64 --transparent --catcher paper -o over.exr
oiiotool --pattern constant:color=0.25,0.35,0.5,1 480x270 4 -o plate.exr
oiiotool over.exr --ch R,G,B,A plate.exr --over --ch R,G,B --colorconvert linear sRGB -d uint8 -o over.png
join catcher 1x1 over.png

render teapot --env "$scenes/studio.hdr" --spp 16 --turntable 240 --frames 1-8 --aov denoising,velocity -o shot.####.exr
"$emberline" denoise shot.####.exr -q -o alone.####.png
"$emberline" denoise shot.####.exr -q --across 2 -o across.####.png
for frame in 000{1..8}; do
  "$emberline" show shot.$frame.exr -q -o raw.$frame.png
  oiiotool {raw,alone,across}.$frame.png --mosaic:pad=4 3x1 -o frame.$frame.png
done
img2webp -loop 0 -lossy -q 80 -d 120 frame.*.png -o "$out/across.webp"

judge() { # arguments: NAME CHANNELS
  render spheres --transparent --catcher paper --driver adaptive --noise-threshold 0.01 --judge "$2" --aov stop -o "$1.exr"
  "$emberline" heatmap "$1.exr" -q --colors viridis --range 16,512 --log --plain -o "$1.png"
}
judge picture RGB
judge shadow RGB,A,shadow:0.005
"$emberline" heatmap shadow.exr -q --of judge --plain -o channels.png
join judge 3x1 picture.png shadow.png channels.png

view() { render glass_metal --size 240x135 --spp 32 --denoise "${@:2}" -o "$1.png"; }
view srgb --view sRGB
view aces --view ACES
view darker --view ACES --exposure -1.5
join views 3x1 srgb.png aces.png darker.png

render teapot --spp 4096 --time-limit 2 -o bucket.png
render teapot --spp 4096 --time-limit 2 --driver adaptive -o adaptive.png
join stopped 2x1 bucket.png adaptive.png

echo '{"emberline_edits": 1, "lights": [{"kind": "material", "name": "window", "intensity": 0.3, "color": [1, 0.6, 0.3]}]}' \
  >relit.json
render teapot --driver adaptive --spp 64 --edits relit.json -o relit.png
join relit 1x1 relit.png
