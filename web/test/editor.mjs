// A real editor for the browser tests: the server as a person starts it, and a page in Chromium.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const CHROMIUM = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
const FLAGS = [
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  // Without a graphics card the stage is drawn by the processor; the rest of the page not by way of it, which is slow.
  "--disable-gpu",
  "--enable-unsafe-swiftshader",
];

/** Start `retime edit`; returns its process and the address that it prints. */
export async function serve(command, folder, environment) {
  const server = spawn(command[0], command.slice(1), { cwd: folder, env: { ...process.env, ...environment } });
  let said = "";
  const address = await new Promise((resolve, reject) => {
    const hear = (data) => {
      said += data;
      const found = /http:\/\/\S+/.exec(said);
      if (found) resolve(found[0]);
    };
    server.stdout.on("data", hear);
    server.stderr.on("data", hear);
    server.on("exit", (code) => reject(new Error(`the server ended with ${code}: ${said}`)));
  });
  const ended = new Promise((resolve) => server.on("exit", resolve));
  return { process: server, address, ended, said: () => said };
}

export async function launch() {
  if (!CHROMIUM) throw new Error("there is no Chromium");
  return chromium.launch({ executablePath: CHROMIUM, headless: true, args: FLAGS });
}

/** A page of the editor, which keeps what went wrong in it and where it asked for anything. */
export class Editor {
  constructor(page) {
    this.page = page;
    this.errors = [];
    this.hosts = new Set();
    page.on("pageerror", (error) => this.errors.push(String(error.stack)));
    page.on("console", (message) => {
      if (message.type() === "error") this.errors.push(message.text());
    });
    page.on("request", (request) => {
      const { host, protocol } = new URL(request.url());
      if (protocol !== "data:" && protocol !== "blob:") this.hosts.add(host);
    });
  }

  static async open(browser, address, { width = 1280, height = 720, scale = 1, dark = false } = {}) {
    const context = await browser.newContext({
      viewport: { width, height },
      deviceScaleFactor: scale,
      colorScheme: dark ? "dark" : "light",
    });
    const editor = new Editor(await context.newPage());
    await editor.page.goto(address);
    await editor.ready();
    await editor.dismiss();
    return editor;
  }

  async ready() {
    await this.page.locator(".veil").waitFor({ state: "hidden", timeout: 60_000 });
  }

  /** Close warnings, as who has read them does: what reading the file assumed is told before the first curve. */
  async dismiss() {
    const close = this.page.locator('.notice[data-kind="warning"] button[aria-label=Close]').first();
    while (await close.count()) await close.click();
  }

  get canvas() {
    return this.page.locator(".timeline > canvas");
  }

  /** Keytimes on the timeline, the end left out. */
  get keys() {
    return this.page.locator("button.handle.key");
  }

  async readout(which) {
    return this.page.locator(`.readout[data-is=${which}] input`).inputValue();
  }

  /** The frame that a readout shows, counted from 0. */
  async frame(which) {
    return Number(/f (\d+)/.exec(await this.page.locator(`.readout[data-is=${which}]`).textContent())[1]);
  }

  /** Wait until a readout shows something else; the panels follow the curve when the hand rests. */
  async changed(which, from) {
    await this.page.waitForFunction(
      ([selector, old]) => document.querySelector(selector).value !== old,
      [`.readout[data-is=${which}] input`, from],
    );
  }

  /** Do something, and wait for the curve that answers it. */
  async answered(action) {
    await this.page.evaluate(() => {
      window.answer = new Promise((resolve) =>
        document.querySelector(".retime").addEventListener("retime:curve", () => resolve(true), { once: true }),
      );
    });
    await action();
    await this.page.evaluate(() => window.answer);
  }

  async setField(name, text) {
    const field = this.page.getByLabel(name, { exact: true });
    await this.answered(async () => {
      await field.fill(text);
      await field.press("Enter");
    });
    await field.blur();
  }

  /** Double-click the map at a share of its width; returns the new keytime. */
  async addKey(share) {
    const box = await this.canvas.boundingBox();
    const before = await this.keys.count();
    await this.answered(() => this.canvas.dblclick({ position: { x: 72 + share * (box.width - 82), y: 80 } }));
    await this.keys.nth(before).waitFor();
    return this.keys.nth(before);
  }

  /** Let every curve come that is on its way: none comes for a while. */
  async settled() {
    await this.page.evaluate(
      () =>
        new Promise((resolve) => {
          const root = document.querySelector(".retime");
          const heard = () => {
            clearTimeout(timer);
            timer = setTimeout(rest, 500);
          };
          const rest = () => {
            root.removeEventListener("retime:curve", heard);
            resolve();
          };
          let timer = setTimeout(rest, 500);
          root.addEventListener("retime:curve", heard);
        }),
    );
  }

  async centre(locator) {
    const box = await locator.boundingBox();
    return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  }

  /** Click the ruler: the playhead goes there. */
  async scrub(share) {
    const box = await this.canvas.boundingBox();
    await this.page.mouse.click(box.x + 72 + share * (box.width - 82), box.y + 12);
    await this.page.mouse.move(box.x + box.width / 2, box.y - 60);
    await this.frames(3);
  }

  /** Open Why, where it is folded away: on a low screen it is at first. */
  async openWhy() {
    const fold = this.page.getByLabel("Why", { exact: true }).getByRole("button", { name: /^Why/ });
    if ((await fold.getAttribute("aria-expanded")) === "false") await fold.click();
  }

  /** Let a few frames pass. */
  async frames(count) {
    await this.page.evaluate(
      (left) =>
        new Promise((resolve) => {
          const next = (n) => (n === 0 ? resolve() : requestAnimationFrame(() => next(n - 1)));
          next(left);
        }),
      count,
    );
  }

  async stage() {
    return (await this.page.locator(".stage").screenshot()).toString("base64");
  }
}

/** Wait until something reads as expected; what it reads at last is in the error. */
export async function until(read, expected) {
  const end = performance.now() + 20_000;
  let found = await read();
  while (found !== expected && performance.now() < end) {
    await new Promise((resolve) => setTimeout(resolve, 30));
    found = await read();
  }
  assert.equal(found, expected);
}

export function percentile(values, share) {
  const ordered = [...values].sort((a, b) => a - b);
  return ordered[Math.min(ordered.length - 1, Math.ceil(share * ordered.length) - 1)];
}

/** What a screen reader's user would stumble over, by the rules of WCAG 2 A and AA. */
export async function stumbles({ page }) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa"] }));
  return violations.flatMap(({ id, nodes }) =>
    nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.failureSummary}`),
  );
}
