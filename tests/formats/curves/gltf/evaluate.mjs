// Evaluates the animations of two glTF scenes with three.js: the one after a warp at t against the one before at warp(t).
// Reads { before, after, three, warps } from its input; writes the largest errors of each animation.
import fs from "node:fs";

globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
const asked = JSON.parse(fs.readFileSync(0, "utf8"));
const { GLTFLoader } = await import(`${asked.three}/examples/jsm/loaders/GLTFLoader.js`);

// Without its pictures, which node can't decode.
function bare(path) {
  const data = fs.readFileSync(path);
  const size = data.readUInt32LE(12);
  const scene = JSON.parse(data.subarray(20, 20 + size).toString());
  for (const kind of ["images", "textures", "materials"]) delete scene[kind];
  for (const mesh of scene.meshes ?? []) for (const part of mesh.primitives) delete part.material;
  let text = JSON.stringify(scene);
  while (Buffer.byteLength(text) % 4) text += " ";
  const body = Buffer.concat([Buffer.from(text), data.subarray(20 + size)]);
  const head = Buffer.alloc(20);
  head.write("glTF");
  [2, 20 + body.length, Buffer.byteLength(text), 0x4e4f534a].forEach((number, i) => head.writeUInt32LE(number, 4 + 4 * i));
  const whole = Buffer.concat([head, body]);
  return whole.buffer.slice(whole.byteOffset, whole.byteOffset + whole.byteLength);
}

const load = (path) => new Promise((done, fail) => new GLTFLoader().parse(bare(path), "", done, fail));

function warped(time, [outputs, inputs]) {
  const k = Math.max(1, outputs.findIndex((knot) => time <= knot));
  const share = (time - outputs[k - 1]) / (outputs[k] - outputs[k - 1]);
  return inputs[k - 1] + share * (inputs[k] - inputs[k - 1]);
}

function degrees(a, b) {
  const unit = (q) => q.map((part) => part / Math.hypot(...q));
  const [p, q] = [unit(a), unit(b)];
  const apart = Math.min(...[1, -1].map((sign) => Math.hypot(...p.map((part, i) => part - sign * q[i]))));
  return (4 * Math.asin(Math.min(1, apart / 2)) * 180) / Math.PI;
}

const [before, after] = [await load(asked.before), await load(asked.after)];
const found = before.animations.map((animation, a) => {
  const warp = asked.warps[a];
  const start = Math.min(...animation.tracks.map((track) => track.times[0]));
  const worst = { tracks: animation.tracks.length, relative: 0, degrees: 0 };
  animation.tracks.forEach((track, k) => {
    const largest = Math.max(...track.values.map(Math.abs));
    const [old, now] = [track.createInterpolant(), after.animations[a].tracks[k].createInterpolant()];
    for (let n = 0; n <= 300; n += 1) {
      const time = (warp[0].at(-1) * n) / 300;
      const [p, q] = [Array.from(old.evaluate(warped(time, warp) + start)), Array.from(now.evaluate(time + start))];
      if (track.name.endsWith("quaternion")) worst.degrees = Math.max(worst.degrees, degrees(p, q));
      else worst.relative = Math.max(worst.relative, ...p.map((part, i) => Math.abs(part - q[i]) / largest));
    }
  });
  return worst;
});
process.stdout.write(JSON.stringify(found));
