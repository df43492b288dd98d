// Work is never lost or stuck: broken files, two tabs, failed exports, servers that die, searches that take too long.
//
//     node safety.mjs '{"python": …, "clip": …, "slow": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the project, for the test to look into.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Editor, launch, serve, until } from "./editor.mjs";

const { python, clip, slow, folder, state, shots } = JSON.parse(process.argv[2]);
const start = (...files) =>
  serve([python, "-m", "retime.cli.main", "edit", ...files, "--no-browser"], folder, { RETIME_STATE: state });

const browser = await launch();
let server = await start(clip);
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "80%");
  const length = page.getByLabel("Length", { exact: true });

  /** Drop a file on the page, at some pixels. */
  const drop = (name, text, x, y) =>
    page.evaluate(
      ([name, text, x, y]) => {
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([text], name));
        const where = { dataTransfer, clientX: x, clientY: y, bubbles: true, cancelable: true };
        document.elementFromPoint(x, y).dispatchEvent(new DragEvent("drop", where));
      },
      [name, text, x, y],
    );
  const note = page.locator(".dropnote");
  for (const [name, text, says] of [
    ["broken.bvh", "HIERARCHY\nROOT hips\n{\n", /^broken\.bvh:3: /],
    ["picture.doc", "nothing", /no format ends in/],
    ["elsewhere.retime", "{}", /does not say where a project lies/],
  ]) {
    await drop(name, text, 300, 200);
    await note.waitFor();
    assert.match(await note.innerText(), says);
    const box = await note.boundingBox();
    assert.ok(Math.abs(box.x - 312) < 2 && Math.abs(box.y - 212) < 2, "the note is beside the drop");
    if (name === "broken.bvh") await shot("refused_drop");
    // The document is there, and can be worked on.
    assert.equal(await page.locator(".veil").isHidden(), true);
    await page.mouse.click(700, 380);
    await note.waitFor({ state: "hidden" });
  }
  // On the references and the clips as well: what can't be read is none of them, and what can be is added.
  const listed = () => page.getByRole("group", { name: "References" }).locator(".pick").allInnerTexts();
  const roles = page.getByLabel(/^Role of /);
  for (const name of ["References", "Clips"]) {
    const section = page.locator(`section[aria-label=${name}]`);
    await section.scrollIntoViewIfNeeded();
    const at = await section.boundingBox();
    const [x, y] = [at.x + 20, at.y + 8];
    await drop("broken.bvh", "HIERARCHY\nROOT hips\n{\n", x, y);
    await note.getByText("broken.bvh:3: ").waitFor();
    const beside = await note.boundingBox();
    assert.ok(beside.x < x + 12.5 && beside.x + beside.width > x - 340 && Math.abs(beside.y - y) < 120);
    await shot(`refused_on_${name.toLowerCase()}`);
    assert.deepEqual(await listed(), ["The clip itself"]);
    assert.equal(await roles.count(), 1);
    assert.equal(await page.getByRole("button", { name: "Undo set length (Ctrl+Z)" }).isEnabled(), true);
    await editor.answered(() => drop("walk.bvh", readFileSync(clip, "utf8"), x, y));
    await note.waitFor({ state: "hidden" });
    if (name === "References") await until(async () => (await listed()).join(), "walk");
    else await until(() => roles.count(), 2);
    await editor.settled();
    await editor.answered(() => page.keyboard.press("Control+z"));
    await until(async () => `${await listed()} ${await roles.count()}`, "The clip itself 1");
  }
  // So it is where a file is chosen: the dialog says why, and stays.
  writeFileSync(join(folder, "damaged.bvh"), "HIERARCHY\nROOT hips\n{\n");
  await page.getByRole("button", { name: "File…", exact: true }).click();
  await page.getByRole("dialog").getByRole("button", { name: "damaged.bvh", exact: true }).click();
  await page.getByRole("dialog").getByText("damaged.bvh:3: ").waitFor();
  await shot("refused_reference");
  await page.getByRole("dialog").getByRole("button", { name: "Cancel" }).click();
  assert.deepEqual(await listed(), ["The clip itself"]);

  await editor.addKey(0.4);
  assert.equal(await length.inputValue(), "80%");

  // Another window is faster: what is lost is told, and can be done again on what holds by then.
  const second = await page.context().newPage();
  let held = null;
  let toPage = () => undefined;
  await second.routeWebSocket(/\/socket$/, (socket) => {
    toPage = (message) => socket.send(message);
    socket.connectToServer().onMessage((message) => (held ? held.push(message) : toPage(message)));
  });
  await second.goto(page.url());
  const other = new Editor(second);
  await other.ready();
  await other.keys.nth(0).waitFor();
  held = [];
  await editor.setField("Length", "75%");
  const box = await other.canvas.boundingBox();
  await other.canvas.dblclick({ position: { x: 72 + 0.7 * (box.width - 82), y: 80 } });
  await other.keys.nth(1).waitFor();
  // Once the server has answered both.
  await until(async () => held.some((message) => String(message).includes('"elsewhere"')), true);
  const late = held;
  held = null;
  for (const message of late) toPage(message);
  await second.getByText("“add key” was not done").waitFor();
  await until(() => other.keys.count(), 1);
  await until(() => second.getByLabel("Length", { exact: true }).inputValue(), "75%");
  await second.screenshot({ path: join(shots, "outrun.png") });
  await second.getByRole("button", { name: "Do it again" }).click();
  await until(() => editor.keys.count(), 2);
  await until(() => length.inputValue(), "75%");
  await second.close();

  // An export that fails keeps its dialog, and what was typed.
  const dialog = page.getByRole("dialog");
  const path = dialog.getByLabel("Path", { exact: true });
  await page.keyboard.press("Control+e");
  const nowhere = join(folder, "not there", "out.bvh");
  await path.fill(nowhere);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await dialog.locator(".refused[role=alert]").waitFor();
  assert.match(await dialog.locator(".refused[role=alert]").innerText(), /not there/);
  assert.equal(await path.inputValue(), nowhere);
  await shot("refused_export");
  await path.fill(join(folder, "out.bvh"));
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await dialog.waitFor({ state: "hidden" });

  // Saved, changed, killed: the old tab says what to type, and comes back by itself once that was typed.
  const project = join(folder, "work.retime");
  await page.keyboard.press("Control+s");
  await path.fill(project);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.locator(".project").getByText("saved", { exact: true }).waitFor();
  await editor.setField("Length", "70%");
  await page.locator(".project").getByText("edited", { exact: true }).waitFor();
  server.process.kill("SIGKILL");
  await server.ended;
  const veil = page.locator(".veil");
  await veil.waitFor();
  assert.equal(await veil.locator("code").innerText(), `retime edit ${clip}`);
  await shot("lost");
  server = await start(clip);
  await veil.waitFor({ state: "hidden", timeout: 30_000 });
  assert.match(server.said(), /going on with .*work\.retime, where these clips were saved/);
  await until(() => length.inputValue(), "70%");
  assert.equal(await editor.keys.count(), 2);
  await page.getByText("The last session ended before this was saved").waitFor();
  await shot("back");
  // Told once: loaded again, the page has nothing to say of it, for no session has ended.
  await page.reload();
  await editor.ready();
  await editor.keys.nth(1).waitFor();
  assert.equal(await page.getByText("The last session ended").count(), 0);
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => length.inputValue(), "75%");
  await page.keyboard.press("Control+s");
  await page.locator(".project").getByText("saved", { exact: true }).waitFor();

  // Nothing was unsaved this time: the project is there, and nobody says that a session ended. One can begin anew.
  server.process.kill("SIGKILL");
  await server.ended;
  await veil.waitFor();
  server = await start(clip);
  await veil.waitFor({ state: "hidden", timeout: 30_000 });
  await page.getByText("This is work.retime, where these clips were saved").waitFor();
  assert.equal(await page.getByText("The last session ended").count(), 0);
  await shot("resumed");
  await page.getByRole("button", { name: "Begin anew" }).click();
  await until(() => editor.keys.count(), 0);
  await until(() => length.inputValue(), "");

  // A project that is dropped is opened where it lies.
  await drop("work.retime", readFileSync(project, "utf8"), 300, 200);
  await until(() => editor.keys.count(), 2);
  await until(
    () =>
      page
        .locator(".project strong, .project")
        .first()
        .innerText()
        .then((text) => text.includes("work.retime")),
    true,
  );

  // A search that takes too long says how far it is, and is stopped; what was there stays.
  server.process.kill("SIGKILL");
  await server.ended;
  server = await start(slow);
  const waiting = await Editor.open(browser, server.address);
  const method = waiting.page.getByLabel("Method", { exact: true });
  const before = await waiting.readout("input");
  await method.selectOption("guided");
  const bar = waiting.page.getByRole("progressbar", { name: "Search" });
  await bar.waitFor({ timeout: 60_000 });
  await waiting.page.screenshot({ path: join(shots, "searching.png") });
  await waiting.page.keyboard.press("Escape");
  await bar.waitFor({ state: "hidden", timeout: 30_000 });
  await waiting.page.locator(".trouble").getByText("the search was stopped").waitFor();
  assert.equal(await waiting.readout("input"), before);
  await waiting.page.screenshot({ path: join(shots, "stopped.png") });
  await waiting.answered(() => waiting.page.keyboard.press("Control+z"));
  await waiting.page.locator(".trouble").waitFor({ state: "hidden" });
  await until(() => method.inputValue(), "linear");

  // Nothing waits behind a search that takes long: a broken clip is refused, the project is saved, a clip is opened.
  await method.selectOption("guided");
  await bar.waitFor({ timeout: 60_000 });
  await waiting.page.keyboard.press("Control+o");
  const opening = waiting.page.getByRole("dialog", { name: "Open" });
  await opening.getByRole("button", { name: "damaged.bvh", exact: true }).click();
  await opening.getByText("damaged.bvh:3: ").waitFor();
  await opening.getByRole("button", { name: "Cancel" }).click();
  await waiting.page.keyboard.press("Control+s");
  await waiting.page.getByText(`Saved ${slow}`).waitFor();
  await bar.waitFor();
  // What has no curve is not written; stopped, the search is not begun anew for it.
  await waiting.page.keyboard.press("Control+e");
  const exporting = waiting.page.getByRole("dialog", { name: "Export" });
  await exporting.getByLabel("Path", { exact: true }).fill(join(folder, "slow_out.csv"));
  await exporting.getByRole("button", { name: "Write", exact: true }).click();
  await exporting.getByText(/^Searching…/).waitFor();
  await waiting.page.screenshot({ path: join(shots, "writing_waits.png") });
  await exporting.getByRole("button", { name: "Stop the search" }).click();
  await exporting.locator(".refused[role=alert]").getByText("the search was stopped").waitFor();
  await exporting.getByRole("button", { name: "Cancel" }).click();
  await method.selectOption("linear");
  await waiting.page.locator(".trouble").waitFor({ state: "hidden" });
  await method.selectOption("guided");
  await bar.waitFor({ timeout: 60_000 });
  await waiting.page.keyboard.press("Control+o");
  await opening.getByRole("button", { name: "sample.bvh", exact: true }).click();
  await waiting.page.getByRole("img", { name: /^Stage: the figures/ }).waitFor({ timeout: 30_000 });
  const covered = waiting.page.locator(".veil");
  await covered.waitFor({ state: "hidden", timeout: 30_000 });

  // A project whose search takes long when it is opened has no curve yet: stopped, it shows what is there.
  await waiting.page.keyboard.press("Control+o");
  await opening.getByRole("button", { name: "slow.retime", exact: true }).click();
  await covered.getByText(/^Searching… .*Esc stops it/).waitFor({ timeout: 60_000 });
  await waiting.page.keyboard.press("Escape");
  await covered.waitFor({ state: "hidden", timeout: 30_000 });
  await waiting.page.locator(".trouble").getByText("the search was stopped").waitFor();
  await waiting.page.screenshot({ path: join(shots, "stopped_opening.png") });
  await method.selectOption("linear");
  await waiting.page.locator(".trouble").waitFor({ state: "hidden" });
  assert.deepEqual(waiting.errors, []);
  console.log(JSON.stringify({ project }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
