// Opens pages of histories in headless Chromium over file:// and checks what is on them.
//
//     node history_checks.mjs TASKS.json
//
// TASKS.json is written by test_history.py; the histories are made up in history_data.mjs. Prints
// one JSON line {name, problem} for each check.
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {check, launch, openPage} from "./browser.mjs";
import {makeHistory, writeHistory} from "./history_data.mjs";

const tasks = JSON.parse(readFileSync(process.argv[2], "utf8"));
const browser = await launch(tasks);
const hostile = "<img src=x onerror=\"window.hacked = 1\"></script><script>window.hacked = 1</script> & \u2028 'x'";
const intended = {who: "Ada", when: "2026-10-01T10:00:00Z", why: "the new filter is meant to be wider"};

const small = makeHistory({runs: 40, series: 48, gaps: false,
  steps: [[1, 10, 1.3, "WORSE"], [5, 30, 1.2, "WORSE"], [9, 30, 1.1, "WORSE"], [13, 35, 1.5, "WORSE", intended], [2, 20, 0.8, "BETTER"], [6, 22, 1.05, "CHANGED"]],
  pictures: [[8, [200, 40, 40]], [9, [200, 40, 40]], [10, [40, 40, 200]], [39, [40, 200, 40]]].map(([run, colour]) => ({run, series: 1, colour}))});
const index = writeHistory(`${tasks.folder}/small`, tasks.dist, small);
const [series, runs] = [small.data.series, small.data.runs];

const open = (path = index, hash = "", options = {}) => openPage(browser, path, hash, options, "#page[data-ready]");
const state = async (page) => new URLSearchParams((await page.evaluate(() => location.hash)).slice(1));
const says = (page, name, value) => page.waitForFunction(([key, wanted]) => new URLSearchParams(location.hash.slice(1)).get(key) === wanted, [name, value]);
const rowKeys = (page) => page.locator(".series").evaluateAll((rows) => rows.sort((a, b) => a.offsetTop - b.offsetTop).map((row) => row.id.replace("series-", "")));
const counted = (page, text) => page.waitForFunction((wanted) => document.querySelector("#series .note").textContent === wanted, text);
const number = (text) => Number(text.replace("\u2212", "-").replace(/ .*$/, ""));
const at = (s, r) => s * runs.length + r;
function near(text, wanted) {
  const value = typeof text === "string" ? number(text) : text;
  assert.ok(Math.abs(value - wanted) <= 2e-3 * Math.abs(wanted), `${text} instead of ${wanted}`);
}

await check("nothing goes wrong and nothing is fetched", async () => {
  const page = await open();
  assert.deepEqual(page.trouble, []);
  assert.equal(await page.locator("h1").textContent(), "occlab: history");
  await counted(page, "48 series");
  await page.context().close();
});

await check("regressions come first, newest first, with their commits", async () => {
  const page = await open();
  const headings = await page.locator("#page h2").allTextContents();
  assert.equal(headings[0], "Regressions");
  const groups = await page.locator("#regressions .commits").evaluateAll((all) => all.map((group) => ({
    range: group.querySelector("h3 code").textContent, subject: group.querySelector("h3").textContent,
    steps: [...group.querySelectorAll(".step")].map((step) => step.className), text: group.textContent})));
  const range = (run) => `${runs[run - 1].commit.slice(0, 10)}..${runs[run].commit.slice(0, 10)}`;
  assert.deepEqual(groups.map((group) => group.range), [range(30), range(10), range(35)]);
  assert.deepEqual(groups.map((group) => group.steps), [["step WORSE", "step WORSE"], ["step WORSE"], ["step WORSE intended"]]);
  assert.ok(groups[0].subject.includes("Change number 30"));
  for (const text of [intended.who, "2026-10-01", intended.why]) assert.ok(groups[2].text.includes(text), groups[2].text);
  assert.equal(await page.locator("#steps .step").count(), 2);
  const bright = await page.locator(".step.WORSE:not(.intended)").first().evaluate((e) => getComputedStyle(e).color);
  assert.notEqual(await page.locator(".step.intended").first().evaluate((e) => getComputedStyle(e).color), bright);
  // The list of all series begins with the same.
  assert.deepEqual((await rowKeys(page)).slice(0, 4), [5, 9, 1, 13].map((i) => series[i].key));
  await page.context().close();
});

await check("the command that calls a change intended", async () => {
  const page = await open(index, "", {permissions: ["clipboard-read", "clipboard-write"]});
  const marking = page.locator("#regressions .commits").nth(1).locator(".marking");
  await marking.locator("summary").click();
  assert.equal(await marking.locator("code").textContent(), `occlab history accept --series ${series[1].key} --commit ${runs[10].commit} --why "..."`);
  await marking.locator("input").fill("it's meant; $(really)");
  const command = `occlab history accept --series ${series[1].key} --commit ${runs[10].commit} --why 'it'\\''s meant; $(really)'`;
  assert.equal(await marking.locator("code").textContent(), command);
  await marking.locator("button").click();
  await marking.getByText("copied").waitFor();
  assert.equal(await page.evaluate(() => navigator.clipboard.readText()), command);
  const group = page.locator("#regressions .commits").first().locator("> .marking");
  await group.locator("summary").click();
  assert.equal((await group.locator("code").textContent()).split("\n").length, 2);
  assert.equal(await page.locator(".step.intended .marking").count(), 0);
  await page.context().close();
});

await check("filters leave what they say and stand in the address", async () => {
  const page = await open();
  const pick = (name, value) => page.locator(`[data-filter="${name}"]`).selectOption(value);
  await pick("method", "s3ho");
  const wanted = series.filter(({method}) => method === "s3ho");
  await counted(page, `${wanted.length} of 48 series`);
  await pick("stage", "filtered");
  await page.locator("[data-filter=text]").fill("gallery RMSE");
  const left = wanted.filter(({stage, scene, metric}) => stage === "filtered" && scene === "gallery" && metric === "rmse").map(({key}) => key);
  assert.ok(left.length > 0 && left.length < wanted.length);
  await counted(page, `${left.length} of 48 series`);
  assert.deepEqual((await rowKeys(page)).sort(), left.sort());
  await says(page, "text", "gallery RMSE");
  const again = await open(index, await page.evaluate(() => location.hash));
  await counted(again, `${left.length} of 48 series`);
  assert.equal(await again.locator("[data-filter=method]").inputValue(), "s3ho");
  assert.equal(await again.locator("[data-filter=text]").inputValue(), "gallery RMSE");
  for (const [verdict, count] of [["open", 3], ["WORSE", 4], ["BETTER", 1], ["CHANGED", 1], ["none", 42]]) {
    const other = await open(index, `#verdict=${verdict}`);
    await counted(other, `${count} of 48 series`);
    await other.context().close();
  }
  await page.getByRole("button", {name: "no filter"}).click();
  await counted(page, "48 series");
  const odd = await open(index, "#method=nothing&from=abc&at=-3&side=z&series=zz");
  await counted(odd, "0 of 48 series");
  assert.deepEqual(odd.trouble, []);
  for (const one of [page, again, odd]) await one.context().close();
});

await check("values under the cursor are those of the history", async () => {
  const page = await open(index, `#series=${series[1].key}`);
  await page.locator(".detail .readout").scrollIntoViewIfNeeded();
  const box = await page.locator(".detail svg").boundingBox();
  const frame = await page.locator(".detail svg .curve").boundingBox();
  for (const run of [0, 9, 10, 39]) {
    await page.mouse.move(frame.x + (run / 39) * frame.width, box.y + box.height / 2);
    await page.waitForFunction((commit) => document.querySelector(".readout code")?.textContent === commit, runs[run].commit.slice(0, 10));
    const cells = await page.locator(".readout tbody tr").first().locator("td").allTextContents();
    near(cells[0], small.value[at(1, run)]);
    const [low, high] = cells[1].slice(1, -1).split(", ");
    near(low, small.lower[at(1, run)]);
    near(high, small.upper[at(1, run)]);
    if (run > 0) assert.ok(Math.abs(number(cells[2].replace("%", "").replace("+", "")) - 100 * (small.value[at(1, run)] / small.value[at(1, run - 1)] - 1)) < 0.06, cells[2]);
    near(cells[3], small.value[at(1, run)] / 0.004);
  }
  assert.equal(await page.locator(".readout tbody tr").count(), 4); // the other methods beside it
  await page.mouse.click(frame.x + (10 / 39) * frame.width, box.y + box.height / 2);
  await says(page, "at", String(runs[10].id));
  await page.context().close();
});

await check("errors in noise floors", async () => {
  const page = await open(index, `#series=${series[1].key}&at=${runs[20].id}`);
  const value = async () => number(await page.locator(".readout tbody tr td").first().textContent());
  near(await value(), small.value[at(1, 20)]);
  await page.locator("[data-filter=floors]").check();
  near(await value(), small.value[at(1, 20)] / 0.004);
  assert.ok((await page.locator(`[id="series-${series[1].key}"] .last`).textContent()).includes("noise floors"));
  await says(page, "floors", "1");
  await page.context().close();
});

await check("files of a plot", async () => {
  const page = await open(index, `#series=${series[1].key}`);
  const save = async (kind) => {
    const [file] = await Promise.all([page.waitForEvent("download"), page.locator(`.detail [data-file=${kind}]`).click()]);
    return readFileSync(await file.path(), "utf8");
  };
  const lines = (await save("csv")).trimEnd().split("\r\n");
  assert.equal(lines.length, 41);
  assert.ok(lines[0].startsWith("run,commit,commit_time,added,device,value,lower,upper"));
  const cells = lines[11].split(",");
  assert.equal(cells[1], runs[10].commit);
  assert.equal(Math.fround(Number(cells[5])), small.value[at(1, 10)]);
  assert.ok(lines[11].includes("WORSE"));
  const text = await save("svg");
  assert.equal(await page.evaluate((xml) => new DOMParser().parseFromString(xml, "image/svg+xml").documentElement.tagName, text), "svg");
  assert.ok(text.includes("step-marker") && !text.includes("var(--"));
  await page.context().close();
});

await check("the keyboard moves along series, runs and steps", async () => {
  const page = await open();
  await page.locator(".series-list").focus();
  await page.keyboard.press("ArrowDown");
  await says(page, "series", series[9].key);
  await page.keyboard.press("End");
  await page.waitForFunction(() => document.querySelector(".series-list").scrollTop > 500);
  await page.goto(page.url().replace(/#.*/, "") + `#series=${series[1].key}&at=${runs[2].id}`);
  await page.locator(".detail .chart").focus();
  await page.keyboard.press("ArrowRight");
  await says(page, "at", String(runs[3].id));
  await page.keyboard.press("]");
  await says(page, "at", String(runs[10].id));
  await page.keyboard.press("+");
  await page.waitForFunction(() => new URLSearchParams(location.hash.slice(1)).has("from"));
  await page.keyboard.press("0");
  await page.waitForFunction(() => !new URLSearchParams(location.hash.slice(1)).has("from"));
  const reached = new Set();
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.className || document.activeElement.tagName.toLowerCase()));
  }
  for (const wanted of ["flip-stage", "button", "select"]) assert.ok(reached.has(wanted), `${wanted} of ${[...reached]}`);
  await page.context().close();
});

/** The colour in the middle of what an element shows. */
async function middle(page, selector) {
  const shot = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluate(async (text) => {
    const image = new Image();
    image.src = `data:image/png;base64,${text}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    return [...context.getImageData(image.width >> 1, image.height >> 1, 1, 1).data.slice(0, 3)];
  }, shot);
}

await check("pictures flip in place between two commits", async () => {
  const page = await open(index, `#a=${runs[9].id}&b=${runs[10].id}`);
  const stage = page.locator(".flip-stage");
  await stage.scrollIntoViewIfNeeded();
  await page.waitForFunction(() => [...document.querySelectorAll(".flip-stage img")].every((image) => image.complete && image.naturalWidth === 640));
  assert.deepEqual(await middle(page, ".flip-stage"), [40, 40, 200]);
  await stage.focus();
  await page.keyboard.press("f");
  await says(page, "side", "a");
  assert.deepEqual(await middle(page, ".flip-stage"), [200, 40, 40]);
  assert.ok((await page.locator(".flip-label").textContent()).includes(runs[9].commit.slice(0, 10)));
  await page.keyboard.press("3");
  assert.deepEqual(await middle(page, ".flip-stage"), [255, 0, 255]);
  const same = await open(index, `#a=${runs[8].id}&b=${runs[9].id}&side=difference`);
  await same.locator(".flip-stage").scrollIntoViewIfNeeded();
  assert.deepEqual(await middle(same, ".flip-stage"), [0, 0, 0]);
  assert.ok((await same.locator(".flip-label").textContent()).includes("no pixel differs"));
  await page.locator("#regressions .commits").nth(1).getByRole("button", {name: "images"}).click();
  await says(page, "b", String(runs[10].id));
  assert.equal((await state(page)).get("a"), String(runs[9].id));
  for (const one of [page, same]) await one.context().close();
});

await check("text from commits stays text", async () => {
  const odd = makeHistory({runs: 12, series: 24, hostile, steps: [[11, 7, 1.4, "WORSE"], [3, 7, 1.4, "WORSE", {who: hostile, when: hostile, why: hostile}]],
    pictures: [{run: 6, series: 11, colour: [1, 2, 3]}, {run: 7, series: 11, colour: [4, 5, 6]}]});
  odd.data.accept_command = `occlab history accept ${hostile}`;
  const page = await open(writeHistory(`${tasks.folder}/hostile`, tasks.dist, odd));
  for (const place of ["h1", "#regressions h3 >> nth=0", "#regressions .intended"]) assert.ok((await page.locator(place).first().textContent()).includes(hostile), place);
  await page.locator("#regressions summary").first().click();
  assert.ok((await page.locator("#regressions pre").first().textContent()).includes(hostile));
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator("img[src=x]").count(), 0);
  assert.deepEqual(page.trouble, []);
  await page.context().close();
});

await check("what cannot be read shows as such", async () => {
  for (const [name, change, words] of [
    ["cut", (data) => { data.values.lower = data.values.lower.slice(0, 40); }, "The curves cannot be shown"],
    ["short", (data) => { data.values.value = data.values.value.length ? makeHistory({runs: 40, series: 47}).data.values.value : ""; }, "values.value"],
    ["format", (data) => { data.format = 2; }, "format 2, this page reads 1"]]) {
    const copy = structuredClone(small.data);
    change(copy);
    const path = writeHistory(`${tasks.folder}/${name}`, tasks.dist, {data: copy, pictures: small.pictures});
    const page = await openPage(browser, path, "", {}, ".notice.problem");
    assert.ok((await page.locator(".notice.problem").textContent()).includes(words), await page.locator("body").textContent());
    await page.context().close();
  }
});

await check("it fits three widths, bright, dark and on paper", async () => {
  for (const [width, height, colorScheme] of [[1280, 900, "light"], [1920, 1080, "dark"], [3840, 2160, "light"]]) {
    const page = await open(index, `#series=${series[1].key}&at=${runs[10].id}`, {viewport: {width, height}, colorScheme});
    for (const id of ["page", "series", "images", "steps"]) {
      await page.evaluate((section) => document.getElementById(section).scrollIntoView(), id);
      await page.waitForTimeout(150);
      await page.screenshot({path: `${tasks.out}/history-${width}-${colorScheme}-${id}.png`, timeout: 120000});
    }
    const {overflow, smallest} = await page.evaluate(() => ({
      overflow: document.scrollingElement.scrollWidth - window.innerWidth,
      smallest: Math.min(...[...document.querySelectorAll("p, td, th, li, small, button, select, text")].map((e) => parseFloat(getComputedStyle(e).fontSize))),
    }));
    assert.ok(overflow <= 0, `${width}: ${overflow} pixels too wide`);
    assert.ok(smallest >= 11, `${width}: text of ${smallest} pixels`);
    await page.context().close();
  }
  const page = await open();
  await page.pdf({path: `${tasks.out}/history-print.pdf`, format: "A4", printBackground: true});
  await page.context().close();
});

await check("2,000 runs of 500 series", async () => {
  const steps = Array.from({length: 300}, (_, i) => [(i * 7) % 500, 50 + ((i * 131) % 1900), i % 3 ? 1.1 : 0.9, i % 3 ? "WORSE" : "BETTER", i % 5 ? null : intended]);
  const large = makeHistory({runs: 2000, series: 500, steps, spikes: [[4, 1234]], seed: 5});
  const path = writeHistory(`${tasks.folder}/large`, tasks.dist, large);
  const page = await open(path, `#series=${large.data.series[4].key}`);
  assert.deepEqual(page.trouble, []);
  const {paint, ready} = await page.evaluate(() => ({paint: Math.min(...performance.getEntriesByType("paint").map(({startTime}) => startTime)), ready: performance.now()}));
  const nodes = await page.locator(".series").count();
  assert.ok(nodes > 4 && nodes < 60, `${nodes} rows exist`);
  // The one run that stands out is drawn, though a pixel stands for several runs.
  const reach = await page.evaluate(() => {
    const ys = document.querySelector(".detail .curve").getAttribute("d").split(/[ML]/).filter(Boolean).map((pair) => Number(pair.split(",")[1]));
    const [low, high] = [Math.min(...ys), Math.max(...ys)], sorted = ys.sort((a, b) => a - b);
    return {points: ys.length, share: (sorted[sorted.length >> 1] - low) / (high - low)};
  });
  assert.ok(reach.share > 0.5 && reach.points < 5000, JSON.stringify(reach));
  const latency = (text) => page.evaluate(async (words) => {
    const input = document.querySelector("[data-filter=text]"), start = performance.now();
    input.value = words;
    input.dispatchEvent(new Event("input"));
    const done = performance.now();
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    return [done - start, performance.now() - start];
  }, text);
  const times = [];
  for (const text of ["s", "s3", "s3ho", "s3ho gal", "s3ho gallery", ""]) times.push(await latency(text));
  await counted(page, "500 series");
  const worst = (i) => Math.max(...times.map((time) => time[i])).toFixed(0);
  console.error(`2000 runs x 500 series: first paint ${Math.round(paint)} ms, all there ${Math.round(ready)} ms; a filter at worst ${worst(0)} ms, painted after ${worst(1)} ms`);
  await page.screenshot({path: `${tasks.out}/history-large.png`});
  await page.context().close();
});

await browser.close();
