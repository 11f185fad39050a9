// Bundles the two pages' scripts and their style sheet into dist/, beside which the pages are copied.
import {copyFileSync} from "node:fs";
import {build} from "esbuild";

await build({
  entryPoints: {app: "src/main.ts", history: "src/history/main.ts", style: "style.css"},
  outdir: "dist",
  bundle: true,
  minify: true,
  format: "iife",
  target: ["es2022"],
  legalComments: "inline",
  charset: "ascii",
  logLevel: "warning",
});
for (const page of ["index.html", "history.html"]) copyFileSync(page, `dist/${page}`);
