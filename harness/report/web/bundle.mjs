// Bundles src/main.ts and the style sheet into dist/, beside which index.html is copied.
import {copyFileSync} from "node:fs";
import {build} from "esbuild";

await build({
  entryPoints: {app: "src/main.ts", style: "style.css"},
  outdir: "dist",
  bundle: true,
  minify: true,
  format: "iife",
  target: ["es2022"],
  legalComments: "inline",
  charset: "ascii",
  logLevel: "warning",
});
copyFileSync("index.html", "dist/index.html");
