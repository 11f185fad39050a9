// The page that `occlab history report` wrote of a history with one planted step: see test_history.py.
import assert from "node:assert/strict";
import {readFileSync, writeFileSync} from "node:fs";
import {check, launch, openPage} from "./browser.mjs";

const tasks = JSON.parse(readFileSync(process.argv[2], "utf8"));
const {commits, step, intended} = tasks;
const browser = await launch(tasks);
const open = (hash = "") => openPage(browser, tasks.index, hash, {}, "#page[data-ready]");
const range = `${commits[step - 1].slice(0, 10)}..${commits[step].slice(0, 10)}`;

await check(`the planted step is found where it is${intended ? ", intended" : ""}`, async () => {
  const page = await open();
  assert.deepEqual(page.trouble, []);
  assert.equal(await page.locator("h1").textContent(), "Real & small: history");
  const group = page.locator("#regressions .commits", {hasText: range});
  assert.ok((await group.locator("h3").textContent()).includes(`Change <b>${step}</b>`));
  const planted = group.locator(".step", {hasText: "s3ho rmse, filtered"});
  assert.ok((await planted.count()) > 0);
  const ratio = Number(/\u00d7 ([\d.]+)/.exec(await planted.first().textContent())[1]);
  assert.ok(Math.abs(ratio - 1.2) < 0.01, `ratio ${ratio}`);
  // No other place of the history has a step of what was planted.
  assert.equal(await page.locator("#regressions .commits", {hasText: "rmse"}).count(), 1);
  assert.equal(await group.locator(".step.intended").count(), intended ? 1 : 0);
  if (intended) {
    assert.ok((await group.locator(".step.intended").textContent()).includes(intended));
  } else {
    await planted.first().locator("summary").click();
    await planted.first().locator("input").fill("it's $(meant)");
    writeFileSync(tasks.command, await planted.first().locator("code").textContent());
  }
  await page.screenshot({path: `${tasks.out}/history-real${intended ? "-intended" : ""}.png`, fullPage: true});
  await page.context().close();
});

await check("its curve and its pictures are there", async () => {
  const page = await open("#text=s3ho+rmse+filtered");
  const points = await page.locator(".detail .curve").getAttribute("d");
  assert.equal(points.split(/[ML]/).length - 1, commits.length);
  await page.locator(".flip-stage").scrollIntoViewIfNeeded();
  await page.waitForFunction(() => [...document.querySelectorAll(".flip-stage img")].every((image) => image.complete && image.naturalWidth > 0));
  await page.locator(".flip-stage").focus();
  const src = (side) => page.locator(".flip-stage img").nth(side).getAttribute("src");
  assert.ok((await src(0)).startsWith("images/") && (await src(1)).startsWith("images/"));
  await page.context().close();
});

await browser.close();
