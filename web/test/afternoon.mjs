// One continuous piece of work, as an animator would do it: a limp that is imitated, a stretch retimed by hand and
// propagated, keytimes moved together, a lock, an export; then the program is killed, and all of it is back.
//
//     node afternoon.mjs '{"python": …, "clip": …, "limp": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: what was exported before the end and after it, and the project that holds it.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, limp, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, "--reference", limp, "--no-browser"];
const start = () => serve(command, folder, { XDG_STATE_HOME: state });

const browser = await launch();
let server = await start();
let scene = 0;
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  /** A picture of every scene, light and dark. */
  const film = async (name) => {
    scene++;
    await editor.frames(4);
    const path = (theme) => join(shots, `${String(scene).padStart(2, "0")}_${name}_${theme}.png`);
    await page.screenshot({ path: path("light") });
    await page.getByRole("button", { name: "Dark theme" }).click();
    await editor.frames(4);
    await page.screenshot({ path: path("dark") });
    await page.getByRole("button", { name: "Light theme" }).click();
  };
  const write = async (path) => {
    await page.keyboard.press("Control+e");
    await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(path);
    await page.getByRole("button", { name: "Write", exact: true }).click();
    await page.getByText(`Wrote ${path}`).waitFor({ timeout: 60_000 });
  };
  const labels = () => editor.keys.evaluateAll((keys) => keys.map((key) => key.getAttribute("aria-label")).sort());
  await page.getByRole("button", { name: "Got it" }).click();

  // The limp is imitated.
  const listed = page.getByRole("group", { name: "References" }).locator(".pick");
  await until(async () => (await listed.allInnerTexts()).join(), "limp");
  await film("limp");

  // A stretch is retimed by hand, and the rest follows it.
  for (const [share, output, input] of [
    [0.2, "120f", "2"],
    [0.35, "4.5", "00:00:03:30"],
  ]) {
    await editor.addKey(share);
    await editor.setField("Output at", output);
    await editor.setField("Shows input", input);
  }
  const propagate = page.locator("section[aria-label=Propagate]");
  await propagate.getByText("Input 2.00 to 3.50 s was retimed by hand; the rest follows.").waitFor();
  await editor.answered(() => propagate.getByRole("button", { name: "Propagate", exact: true }).click());
  const speaks = propagate.getByText(/^The example speaks for \d+ % of the clip\./);
  await speaks.waitFor();
  await film("propagated");

  // One more keytime, where the example says nothing; then two are moved as one.
  const third = await editor.addKey(0.7);
  await editor.settled();
  const before = await labels();
  assert.equal(before.length, 3);
  const points = [];
  for (const key of await editor.keys.all()) points.push(await editor.centre(key));
  points.sort((a, b) => a.x - b.x);
  const [first, second] = points;
  await page.mouse.move(first.x - 18, Math.max(first.y, second.y) + 18);
  await page.mouse.down();
  await page.mouse.move(second.x + 18, Math.min(first.y, second.y) - 18, { steps: 6 });
  await page.mouse.up();
  await page.getByRole("heading", { name: "2 keytimes", exact: true }).waitFor();
  await film("chosen");
  const where = await third.getAttribute("aria-label");
  await page.mouse.move(first.x, first.y);
  await page.mouse.down();
  await page.mouse.move(first.x + 20, first.y, { steps: 5 });
  await editor.answered(() => page.mouse.up());
  await editor.settled();
  const moved = await labels();
  assert.equal(await third.getAttribute("aria-label"), where);
  assert.equal(moved.filter((label) => !before.includes(label)).length, 2);

  // A stretch is locked: it plays at its own speed.
  const band = await page.locator(".timeline .overlay[aria-label=Locks]").boundingBox();
  const low = band.y + band.height * 0.35;
  await page.mouse.move(band.x - 20, low);
  await page.mouse.down();
  await page.mouse.move(band.x - 20, low - 14, { steps: 4 });
  await editor.answered(() => page.mouse.up());
  await page.locator(".handle.band").waitFor();
  await editor.settled();
  assert.equal(await page.locator(".trouble").isVisible(), false);
  await film("locked");
  assert.deepEqual(await stumbles(editor), []);

  // Exported; then the program is killed, and the same command brings all of it back.
  const exported = join(folder, "before.bvh");
  await write(exported);
  await film("exported");
  const curve = await page.getByLabel("Lock from").inputValue();
  server.process.kill("SIGKILL");
  await server.ended;
  const errors = [...editor.errors];
  server = await start();
  await page.goto(server.address);
  await editor.ready();
  await page.getByText("Everything that was done is back").waitFor();
  await film("back");
  await editor.dismiss();
  assert.deepEqual(await labels(), moved);
  assert.equal(await page.getByLabel("Lock from").inputValue(), curve);
  await speaks.waitFor();
  // Undo, too: the lock goes, and comes again.
  await editor.answered(() => page.keyboard.press("Control+z"));
  await page.locator(".handle.band").waitFor({ state: "detached" });
  await editor.answered(() => page.keyboard.press("Control+Shift+z"));
  await page.locator(".handle.band").waitFor();
  await editor.settled();
  const again = join(folder, "after.bvh");
  await write(again);
  const project = join(folder, "afternoon.retime");
  await page.keyboard.press("Control+s");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(project);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Saved ${project}`).waitFor();

  assert.deepEqual(errors, []);
  console.log(JSON.stringify({ exported, again, project, scenes: scene }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
