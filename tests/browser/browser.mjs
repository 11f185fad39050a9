// What the checks of the pages share: a browser whose pages note their troubles, and checks as lines
// of JSON {name, problem}.
import {createRequire} from "node:module";
import {pathToFileURL} from "node:url";

export async function launch(tasks) {
  const {chromium} = createRequire(tasks.modules + "/")("playwright-core");
  return chromium.launch({
    executablePath: tasks.chromium,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  });
}

export async function check(name, body) {
  let problem = "";
  try {
    await body();
  } catch (error) {
    problem = String(error.stack ?? error);
  }
  console.log(JSON.stringify({name, problem}));
}

/** A page that notes every error and every request that is not for a file. */
export async function openPage(browser, index, hash, options, ready) {
  const context = await browser.newContext({viewport: {width: 1280, height: 900}, offline: true, acceptDownloads: true, ...options});
  context.setDefaultTimeout(40000);
  const page = await context.newPage();
  page.trouble = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && page.trouble.push(message.text()));
  page.on("pageerror", (error) => page.trouble.push(error.message));
  page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || page.trouble.push(`request: ${request.url()}`));
  await page.goto(pathToFileURL(index).href + hash);
  await page.waitForSelector(ready);
  return page;
}
