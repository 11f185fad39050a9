// Opens reports in headless Chromium over file:// and checks what is on the page.
//
//     node page_checks.mjs TASKS.json
//
// TASKS.json is written by test_report.py: where the pages are and what must be on them, read from
// the EXR files without any of occlab's code. Prints one JSON line {name, problem} for each check.
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {pathToFileURL} from "node:url";
import {check, launch, openPage} from "./browser.mjs";

const tasks = JSON.parse(readFileSync(process.argv[2], "utf8"));
const browser = await launch(tasks);
const open = (index, hash = "", options = {}) => openPage(browser, index, hash, options, "#cells");

/** Waits until the images show the latest change, and the address says it. */
async function drawn(page) {
  await page.waitForFunction(() => {
    const {drawn, address} = document.querySelector(".stage").dataset;
    return drawn === "true" && address === "written";
  }, null, {timeout: 30000});
}

/** Of the canvas' pixels in a panel: their colours (0xrrggbb), the middle one, and a checksum. */
function readPanel(page, index) {
  return page.evaluate((at) => {
    const canvas = document.querySelector(".stage canvas");
    const panel = document.querySelectorAll(".stage .panel")[at].dataset;
    const ratio = canvas.width / canvas.clientWidth;
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const {width, height, data} = context.getImageData(Math.round(panel.x * ratio), Math.round(panel.y * ratio),
      Math.floor(panel.width * ratio), Math.floor(panel.height * ratio));
    const colours = new Set();
    let checksum = 0;
    for (let i = 0; i < data.length; i += 4) {
      const colour = (data[i] << 16) | (data[i + 1] << 8) | data[i + 2];
      colours.add(colour);
      checksum = (Math.imul(checksum, 31) + colour) | 0;
    }
    const middle = 4 * (Math.floor(height / 2) * width + Math.floor(width / 2));
    return {colours: [...colours].slice(0, 2000), middle: Array.from(data.slice(middle, middle + 3)), checksum};
  }, index);
}

/** Waits until the address says so: it is written a little after the picture. */
function says(page, name, value) {
  return page.waitForFunction(([key, wanted]) => new URLSearchParams(location.hash.slice(1)).get(key) === wanted, [name, value]);
}

const state = async (page) => new Map(new URLSearchParams((await page.evaluate(() => location.hash)).slice(1)));
const panelCount = (page) => page.locator(".stage .panel").count();
const {smoke} = tasks;

await check("nothing goes wrong and nothing is fetched", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  await page.evaluate(() => document.querySelectorAll("details.table").forEach((table) => { table.open = true; }));
  await page.waitForFunction(() => document.querySelectorAll("details.table table").length === document.querySelectorAll("details.table").length);
  assert.deepEqual(page.trouble, []);
  assert.equal(await page.locator(".badge").count(), 0);
  assert.equal(await page.locator("h1").textContent(), `${smoke.title} `);
  assert.equal(await page.locator("details.table").count(), smoke.tables);
  const paint = await page.evaluate(() => performance.getEntriesByType("paint").map(({startTime}) => startTime));
  console.error(`first paint ${Math.round(Math.min(...paint))} ms`);
  await page.context().close();
});

await check("images are not blank, each another one", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  assert.equal(await panelCount(page), 5);
  const seen = new Set();
  for (let i = 0; i < 5; ++i) {
    const image = await readPanel(page, i);
    assert.ok(image.colours.length > 50, `panel ${i} has ${image.colours.length} colours`);
    seen.add(image.checksum);
  }
  assert.equal(seen.size, 5);
  await page.context().close();
});

await check("pixels on the canvas are those of the EXR, the right way up", async () => {
  for (const {active, x, y, shown} of smoke.canvas) {
    const page = await open(smoke.index, `#mode=flip&active=${active}&zoom=32&x=${x + 0.5}&y=${y + 0.5}`);
    await drawn(page);
    const {middle} = await readPanel(page, 0);
    shown.forEach((value, c) => assert.ok(Math.abs(middle[c] - value) <= 1,
      `image ${active}, pixel ${x}, ${y}: ${middle} instead of ${shown}`));
    await page.context().close();
  }
});

await check("the difference of an image with itself is zero", async () => {
  for (const [as, colour] of [["signed", smoke.zeroSigned], ["relative", smoke.zeroSigned], ["angle", smoke.zeroAngle]]) {
    const page = await open(smoke.index, `#as=${as}`);
    await drawn(page);
    const itself = (await readPanel(page, 0)).colours.filter((found) => found !== 0x808080);
    assert.equal(itself.length, 1, `${as}: ${itself.length} colours`);
    [16, 8, 0].forEach((shift, c) => assert.ok(Math.abs(((itself[0] >> shift) & 255) - colour[c]) <= 1, `${as}: ${itself[0].toString(16)}`));
    for (let i = 1; i < 5; ++i) assert.ok((await readPanel(page, i)).colours.length > 30, `${as}: panel ${i} is flat`);
    await page.context().close();
  }
});

await check("values under the cursor are those of the EXR, of all images at once", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  await page.locator(".stage").scrollIntoViewIfNeeded();
  const box = await page.locator(".stage").boundingBox();
  for (const {x, y, layers} of smoke.pixels) {
    const panel = await page.evaluate(() => ({...document.querySelectorAll(".stage .panel")[1].dataset}));
    await page.mouse.move(box.x + Number(panel.x) + (x + 0.5) / smoke.width * panel.width,
      box.y + Number(panel.y) + (y + 0.5) / smoke.height * panel.height);
    await page.waitForFunction((text) => document.querySelector(".readout th").textContent === text, `pixel ${x}, ${y}`);
    const rows = await page.evaluate(() => Object.fromEntries([...document.querySelectorAll(".readout tbody tr")].map((row) =>
      [row.dataset.layer, [...row.querySelectorAll("[data-value]")].map((cell) => Number(cell.dataset.value))])));
    assert.deepEqual(rows, layers);
  }
  await page.context().close();
});

await check("keys flip, zoom and choose; the address follows", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  await page.locator(".stage").focus();
  const labels = () => page.locator(".stage .label span").allTextContents();
  const all = await labels();
  for (const key of ["2", "5", "1"]) {
    await page.keyboard.press(key);
    await says(page, "active", String(Number(key) - 1));
    await says(page, "mode", "flip");
    await drawn(page);
    assert.deepEqual(await labels(), [all[Number(key) - 1]]);
  }
  const expectations = [["g", "mode", "grid"], ["d", "as", "signed"], ["d", "as", "relative"], ["e", "ev", "0.5"],
    ["E", "ev", "0"], ["+", "zoom", "1.5"], ["s", "mode", "slider"], ["0", "zoom", "1"], ["f", "mode", "flip"]];
  for (const [key, name, value] of expectations) {
    await page.keyboard.press(key);
    await says(page, name, value);
  }
  await page.keyboard.press("l");
  await says(page, "layer", "radiance_unfiltered");
  await page.keyboard.press("Shift+ArrowRight");
  await says(page, "pin", `${smoke.width / 2 + 1},${smoke.height / 2}`);
  assert.deepEqual(page.trouble, []);
  await page.context().close();
});

await check("an address opens the same view again", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  await page.locator(".closeups button").first().click();
  await page.locator(".stage").focus();
  for (const key of ["3", "d", "e"]) await page.keyboard.press(key);
  await drawn(page);
  const box = await page.locator(".stage").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 3);
  await page.mouse.move(2, 2);
  await drawn(page);
  const [hash, image, text] = [await page.evaluate(() => location.hash), await readPanel(page, 0), await page.locator(".readout").innerText()];
  assert.ok(Number((await state(page)).get("zoom")) > 1 && (await state(page)).get("pin"));
  const again = await open(smoke.index, hash);
  await drawn(again);
  // The other images' values come with the other images.
  assert.equal(await again.evaluate(() => location.hash), hash);
  assert.deepEqual(await readPanel(again, 0), image);
  assert.equal((await again.locator(".readout th").first().innerText()), text.split(/[\n\t]/)[0]);
  await page.context().close();
  await again.context().close();
});

await check("every layer of every choice is drawn", async () => {
  const page = await open(smoke.index);
  const show = page.locator(".control:has(span:text-is('show')) select");
  const layer = page.locator(".control:has(span:text-is('layer')) select");
  let pictures = 0;
  for (const set of await show.locator("option").all()) {
    await show.selectOption(await set.getAttribute("value"));
    const names = (await layer.isVisible()) ? await layer.locator("option").evaluateAll((options) => options.map(({value}) => value)) : [""];
    for (const name of names) {
      if (name) await layer.selectOption(name);
      await drawn(page);
      for (let i = 0; i < (await panelCount(page)); ++i, ++pictures) {
        const {colours} = await readPanel(page, i);
        assert.ok(!colours.includes(0xff00ff), `${name}: not finite`);
      }
    }
  }
  assert.ok(pictures > 40, `${pictures} pictures`);
  assert.deepEqual(page.trouble, []);
  await page.context().close();
});

await check("marks lead to their cells", async () => {
  const page = await open(smoke.index);
  const links = page.locator("#plot-pareto svg a");
  assert.equal(await links.count(), smoke.groups);
  for (const plot of await page.locator(".plot").all()) assert.ok((await plot.locator("svg a").count()) > 0);
  const marks = await page.locator(".plot svg a").evaluateAll((all) => all.map((a) => a.getAttribute("href") ?? a.getAttributeNS("http://www.w3.org/1999/xlink", "href")));
  for (const mark of new Set(marks)) {
    const id = mark.replace("#cell=", "");
    assert.ok(smoke.cells.includes(id) || (await page.locator(`[id="${id}"]`).count()) === 1, mark);
  }
  await links.nth(2).dispatchEvent("click");
  await page.waitForSelector("#cells .found");
  const id = (await page.evaluate(() => location.hash)).match(/cell=([0-9a-f]{16})/)[1];
  assert.equal(await page.locator(`.found [id="cell-${id}"]`).count(), 1);
  await page.locator(".found a", {hasText: "look at it"}).click();
  await drawn(page);
  assert.equal((await state(page)).get("mode"), "flip");
  await page.context().close();
});

await check("plots are there as SVG and CSV", async () => {
  const page = await open(smoke.index);
  const plots = await page.locator(".plot").all();
  assert.ok(plots.length >= 6, `${plots.length} plots`);
  for (const plot of plots) {
    for (const kind of ["svg", "csv"]) {
      await page.waitForTimeout(110);  // Chromium drops what a page saves beyond ten files a second
      const [file] = await Promise.all([page.waitForEvent("download"), plot.locator(`[data-file=${kind}]`).click()]);
      const text = readFileSync(await file.path(), "utf8");
      if (kind === "csv") {
        const lines = text.trimEnd().split("\r\n");
        assert.ok(lines.length > 4 && lines[0].startsWith("method,") && lines[0].includes(",value,"), text.slice(0, 200));
      } else {
        const kindOfRoot = await page.evaluate((xml) => new DOMParser().parseFromString(xml, "image/svg+xml").documentElement.tagName, text);
        assert.equal(kindOfRoot, "svg");
        assert.ok(!text.includes("var(--"), "colours of the page");
      }
    }
  }
  await page.context().close();
});

await check("a plot's files are there before it is laid out", async () => {
  const context = await browser.newContext({offline: true, acceptDownloads: true});
  const page = await context.newPage();
  // Clicks as soon as the plot is in the page, which is before anything is measured for layout.
  await page.addInitScript(() => new MutationObserver((_, self) => {
    const csv = document.querySelector("#plot-pareto [data-file=csv]");
    if (!csv) return;
    self.disconnect();
    window.drawnBefore = document.querySelectorAll("#plot-pareto .chart svg").length;
    csv.click();
  }).observe(document, {childList: true, subtree: true}));
  const [file] = await Promise.all([page.waitForEvent("download", {timeout: 40000}), page.goto(pathToFileURL(smoke.index).href)]);
  assert.ok(readFileSync(await file.path(), "utf8").startsWith("method,"));
  assert.equal(await page.evaluate(() => window.drawnBefore), 0);
  await context.close();
});

await check("axes are labelled, spectra are drawn", async () => {
  const page = await open(smoke.index);
  const ticks = await page.locator("#plot-pareto [aria-label='x-axis tick label'] text").allTextContents();
  assert.ok(ticks.length >= 2 && ticks.every(Boolean), `labels: ${ticks}`);
  assert.ok((await page.locator("#plot-spectra svg a").count()) > 100);
  await page.context().close();
});

await check("a click draws the pixel's lobes", async () => {
  const {x, y, irradiance, angle} = smoke.lobe;
  const page = await open(smoke.index, `#pin=${x},${y}`);
  await page.waitForSelector("[data-lobe=cone]");
  const lobes = await page.locator("[data-lobe]").evaluateAll((figures) => figures.map((figure) => {
    const canvas = figure.querySelector("canvas");
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    return {key: figure.dataset.lobe, text: figure.textContent, colours: new Set(new Uint32Array(data.buffer)).size};
  }));
  assert.deepEqual(lobes.map(({key}) => key), ["visibility", "product", "light", "cone"]);
  for (const {key, colours: count} of lobes) assert.ok(count > 100, `${key}: ${count} colours`);
  const numbers = lobes[1].text.match(/irradiance, (.*)$/)[1].split(", ").map((text) => Number(text.replace("\u2212", "-")));
  numbers.forEach((value, c) => assert.ok(Math.abs(value - irradiance[c]) < 2e-3 * Math.abs(irradiance[c]) + 1e-3, `${numbers} instead of ${irradiance}`));
  const degrees = Number(lobes[3].text.match(/half-angle ([\d.]+)/)[1]);
  assert.ok(Math.abs(degrees - angle) < 0.2, `${degrees} instead of ${angle} degrees`);
  await page.context().close();
});

await check("the keyboard reaches everything", async () => {
  const page = await open(smoke.index);
  await drawn(page);
  const wanted = ["select", "input", "button", "div.stage", "a", "summary"];
  const reached = new Set();
  let presses = 0;
  for (; presses < 1000 && !wanted.every((element) => reached.has(element)); ++presses) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => {
      const element = document.activeElement;
      return `${element.tagName.toLowerCase()}${element.classList.contains("stage") ? ".stage" : ""}`;
    }));
  }
  for (const element of wanted) assert.ok(reached.has(element), `${element} is not reached`);
  console.error(`the keyboard reaches everything within ${presses} presses`);
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, select, input")].filter((element) =>
    !(element.textContent.trim() || element.getAttribute("aria-label") || element.closest("label"))).length);
  assert.equal(nameless, 0);
  await page.context().close();
});

await check("it fits three widths, bright, dark and on paper", async () => {
  for (const [width, height, colorScheme] of [[1280, 900, "light"], [1920, 1080, "dark"], [3840, 2160, "light"]]) {
    const page = await open(smoke.index, "#pin=70,50", {viewport: {width, height}, colorScheme});
    await drawn(page);
    const paint = await page.evaluate(() => performance.getEntriesByType("paint").map(({startTime}) => startTime));
    console.error(`${width} wide: first paint ${Math.round(Math.min(...paint))} ms`);
    for (const id of ["page", "viewer", "lobes", "plots", "tables", "figures", "cells"]) {
      await page.evaluate((section) => document.getElementById(section).scrollIntoView(), id);
      await page.waitForTimeout(150);
      await page.screenshot({path: `${tasks.out}/${width}-${colorScheme}-${id}.png`, timeout: 120000});
    }
    const {overflow, smallest} = await page.evaluate(() => ({
      overflow: document.scrollingElement.scrollWidth - window.innerWidth,
      smallest: Math.min(...[...document.querySelectorAll("p, td, th, li, button, select, figcaption")].map((e) => parseFloat(getComputedStyle(e).fontSize))),
    }));
    assert.ok(overflow <= 0, `${width}: ${overflow} pixels too wide`);
    assert.ok(smallest >= 12, `${width}: text of ${smallest} pixels`);
    await page.context().close();
  }
  const page = await open(smoke.index);
  await drawn(page);
  await page.pdf({path: `${tasks.out}/print.pdf`, format: "A4", printBackground: true});
  await page.context().close();
});

await check("what is wrong with a run shows on its page", async () => {
  for (const {index, texts, panels} of tasks.broken) {
    const page = await open(index);
    await page.waitForTimeout(1500);
    const text = await page.locator("body").innerText();
    for (const wanted of texts) assert.ok(text.includes(wanted), `${index}: '${wanted}' is not in\n${text.slice(0, 1500)}`);
    assert.equal(await panelCount(page), panels, index);
    assert.deepEqual(page.trouble.filter((line) => !line.includes("ERR_FILE_NOT_FOUND")), []);
    await page.context().close();
  }
});

await check("text from files stays text", async () => {
  const page = await open(tasks.hostile.index);
  await page.waitForTimeout(500);
  assert.ok((await page.locator("h1").textContent()).includes(tasks.hostile.text));
  assert.ok((await page.locator(".notice.warning").textContent()).includes(tasks.hostile.text));
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator("img[src=x]").count(), 0);
  assert.deepEqual(page.trouble, []);
  await page.context().close();
});

await browser.close();
