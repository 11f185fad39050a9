// Histories as occlab writes them into their page, made up from known numbers.
import {copyFileSync, mkdirSync, readFileSync, writeFileSync} from "node:fs";
import {crc32, deflateSync} from "node:zlib";
import {createHash} from "node:crypto";

/** Numbers in [0, 1), the same in every run (Marsaglia's xorshift). */
function generator(seed) {
  let state = seed | 0 || 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) / 2 ** 32;
  };
}

const hex = (text, length) => createHash("sha256").update(text).digest("hex").slice(0, length);

function checksum(bytes) {
  if (crc32) return crc32(bytes);
  let sum = ~0;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; ++bit) sum = (sum >>> 1) ^ (0xedb88320 & -(sum & 1));
  }
  return ~sum >>> 0;
}

/** A PNG of one colour. */
export function png(width, height, [red, green, blue]) {
  const chunk = (kind, body) => {
    const bytes = Buffer.alloc(12 + body.length);
    bytes.writeUInt32BE(body.length, 0);
    bytes.write(kind, 4, "latin1");
    body.copy(bytes, 8);
    bytes.writeUInt32BE(checksum(bytes.subarray(4, 8 + body.length)), 8 + body.length);
    return bytes;
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const row = Buffer.concat([Buffer.from([0]), Buffer.alloc(3 * width, Buffer.from([red, green, blue]))]);
  const pixels = deflateSync(Buffer.concat(Array.from({length: height}, () => row)));
  return Buffer.concat([Buffer.from("89504e470d0a1a0a", "hex"), chunk("IHDR", header), chunk("IDAT", pixels), chunk("IEND", Buffer.alloc(0))]);
}

function makeRuns(count, hostile) {
  return Array.from({length: count}, (_, i) => {
    const time = new Date(Date.UTC(2021, 0, 1) + i * 21 * 3600e3).toISOString();
    return {id: 100 + i, commit: hex(`commit ${i}`, 40), subject: i === 7 && hostile ? hostile : `Change number ${i}`, commit_time: time,
      added: time, experiment: "regression", device: "llvmpipe (software)", baseline: i === 3};
  });
}

function makeSeries(count, hostile) {
  const scenes = ["gallery", "three_boxes", "courtyard"], methods = ["ssao", "s3ho", "ssdo", "ssbn"];
  const metrics = ["rmse", "noise", "psnr", "flip_hdr", "time_ms.occlusion"], stages = ["unfiltered", "filtered"];
  return Array.from({length: count}, (_, i) => {
    let rest = i;
    const take = (list) => {
      const value = list[rest % list.length];
      rest = Math.floor(rest / list.length);
      return value;
    };
    const method = take(methods), metric = take(metrics), stage = take(stages), scene = take(scenes);
    const timed = metric.startsWith("time");
    return {key: hex(`series ${i}`, 16), experiment: "regression", scene: i === 11 && hostile ? hostile : scene, view: "main", resolution: "640x360",
      probe: "cathedral, filtered 8 deg", method, parameters: {samples: String(8 * (1 + rest % 4)), set: String(Math.floor(rest / 4))}, stage: timed ? "" : stage, metric,
      unit: timed ? "ms" : metric === "psnr" ? "dB" : "mean luminance", device: "llvmpipe (software)",
      better: metric === "psnr" ? "higher" : "lower", noise_floor: timed || metric === "psnr" ? null : 0.004};
  });
}

/** The steps of series: [series, run, factor, verdict, intended]. */
export function makeHistory({runs, series, steps = [], spikes = [], pictures = [], hostile = "", seed = 1, gaps = true}) {
  const random = generator(seed);
  const value = new Float32Array(runs * series).fill(NaN), lower = value.slice(), upper = value.slice();
  const allSeries = makeSeries(series, hostile), allRuns = makeRuns(runs, hostile);
  const found = [];
  for (let s = 0; s < series; ++s) {
    let level = 0.05 + 0.4 * random();
    const own = steps.filter((step) => step[0] === s);
    for (let r = 0; r < runs; ++r) {
      const step = own.find((one) => one[1] === r);
      if (step) {
        found.push({series: s, run: r, before_run: r - 1, before: level, after: level * step[2], lower: step[2] * 0.98, upper: step[2] * 1.02,
          p: 1e-6, verdict: step[3], intended: step[4] ?? null});
        level *= step[2];
      }
      const measured = level * (1 + 0.01 * (random() - 0.5)) * (spikes.some(([a, b]) => a === s && b === r) ? 3 : 1);
      if (gaps && random() < 0.01 && !step) continue;
      const at = s * runs + r;
      [value[at], lower[at], upper[at]] = [measured, measured * 0.98, measured * 1.02];
    }
  }
  const packed = (array) => deflateSync(Buffer.from(array.buffer), {level: 1}).toString("base64");
  const data = {format: 1, written: "2026-11-22T12:00:00Z", project: hostile || "occlab", level: 0.05, minimum_effect: 0.02,
    runs: allRuns, series: allSeries, steps: found,
    values: {encoding: "float32 little endian, series by series, deflate (zlib), base64", value: packed(value), lower: packed(lower), upper: packed(upper)},
    images: pictures.map(({run, series: index, colour}) => {
      const {scene, view, method, stage} = allSeries[index];
      return {run, scene, view, method, parameters: {samples: allSeries[index].parameters.samples}, stage, file: `images/${hex(colour.join(), 16)}.png`};
    })};
  return {data, value, lower, upper, pictures};
}

/** Writes a page from the bundle in `dist` and what it needs; returns the path of its index.html. */
export function writeHistory(folder, dist, {data, pictures}) {
  mkdirSync(`${folder}/images`, {recursive: true});
  data.images.forEach(({file}, i) => writeFileSync(`${folder}/${file}`, png(640, 360, pictures[i].colour)));
  for (const name of ["history.js", "style.css"]) copyFileSync(`${dist}/${name}`, `${folder}/${name}`);
  const {values, ...rest} = data;
  const inline = (part) => JSON.stringify(part).replaceAll("<", "\\u003c");
  const page = readFileSync(`${dist}/history.html`, "utf8");
  writeFileSync(`${folder}/index.html`, page.replace("/*occlab-values*/", () => inline(values)).replace("/*occlab-data*/", () => inline(rest)));
  return `${folder}/index.html`;
}
