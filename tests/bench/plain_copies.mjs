// Makes copies of scenes that any reader accepts: without compressed meshes or quantized positions, and with
// PNG instead of WebP. The race against Cycles (race_cycles.py) uses the copies, since Blender's importer does
// not read the originals.
//
//     npm install --prefix DIR @gltf-transform/core @gltf-transform/extensions @gltf-transform/functions \
//         draco3dgltf meshoptimizer sharp
//     NODE_PATH=DIR/node_modules node tests/bench/plain_copies.mjs ASSETS OUT
//
// OUT gets copies of ASSETS/views.json, of the environments that it names, and of each of its scenes, under
// the same names. A scene that cannot be converted (KTX 2) is copied unchanged, with a message.
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const find = createRequire(path.join(process.env.NODE_PATH ?? "node_modules", "/"));
const { NodeIO } = find("@gltf-transform/core");
const { ALL_EXTENSIONS } = find("@gltf-transform/extensions");
const { dequantize, textureCompress } = find("@gltf-transform/functions");
const { MeshoptDecoder } = find("meshoptimizer");
const sharp = find("sharp");

const COMPRESSED = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization", "EXT_texture_webp"];

const [assets, out] = process.argv.slice(2);
const views = JSON.parse(fs.readFileSync(path.join(assets, "views.json")));
await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
  "draco3d.decoder": await find("draco3dgltf").createDecoderModule(),
  "meshopt.decoder": MeshoptDecoder,
});
io.setStrictResources(false);

async function make_plain(from, to) {
  const scene = await io.read(from);
  const used = scene.getRoot().listExtensionsUsed();
  if (!used.some((e) => COMPRESSED.includes(e.extensionName))) {
    return fs.cpSync(path.dirname(from), path.dirname(to), { recursive: true, dereference: true });
  }
  await scene.transform(dequantize({ pattern: /.*/ }),
                        textureCompress({ encoder: sharp, formats: /webp/, targetFormat: "png" }));
  for (const extension of used) if (COMPRESSED.includes(extension.extensionName)) extension.dispose();
  fs.mkdirSync(path.dirname(to), { recursive: true });
  await io.write(to, scene);
  console.log(`${from}: ${used.map((e) => e.extensionName).join(", ")}`);
}

fs.mkdirSync(out, { recursive: true });
fs.writeFileSync(path.join(out, "views.json"), JSON.stringify(views, null, 1));
for (const [name, view] of Object.entries(views)) {
  if (!name.startsWith("scenes/")) continue;
  if (view.env) fs.cpSync(path.join(assets, view.env), path.join(out, view.env));
  try {
    await make_plain(path.join(assets, name), path.join(out, name));
  } catch (error) {
    console.error(`${name} is copied as it is: ${error.message}`);
    fs.cpSync(path.dirname(path.join(assets, name)), path.dirname(path.join(out, name)), { recursive: true });
  }
}
