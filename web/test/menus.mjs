// Welcome, menus of the right button, shortcuts that are searched, and ways to turn the stage, in a real browser.
//
//     node menus.mjs '{"python": …, "recent": …, "folder": …, "state": …, "shots": …}'
//
// `recent` is a clip that is opened before.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, recent, folder, state, shots } = JSON.parse(process.argv[2]);
const begin = (...names) =>
  serve([python, "-m", "retime.cli.main", "edit", ...names, "--no-browser"], folder, {
    XDG_STATE_HOME: state,
    RETIME_STATE: join(state, "retime"),
  });

const browser = await launch();
const before = await begin(recent);
before.process.kill("SIGINT");
await before.ended;
const server = await begin();
try {
  // Over the welcome nothing else can be clicked: it is met before any notice is dismissed.
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "light" });
  const editor = new Editor(await context.newPage());
  const { page } = editor;
  await page.goto(server.address);
  await editor.ready();
  const shot = (name) => page.screenshot({ path: join(shots, `menu_${name}.png`) });

  // Without a clip the sample lies open, under what was opened last.
  const welcome = page.getByRole("dialog", { name: "Welcome" });
  await welcome.waitFor();
  await shot("welcome");
  assert.deepEqual(await stumbles(editor), []);
  assert.equal(await page.locator(".project b").innerText(), "sample");
  await welcome.getByRole("button", { name: recent }).click();
  await until(() => page.locator(".project b").innerText(), recent.replace(/\.bvh$/, ""));
  await page.reload();
  await editor.ready();
  await welcome.getByRole("button", { name: "Try the sample" }).click();
  await page.getByRole("region", { name: "First steps" }).getByText(/lock/).waitFor();
  await page
    .getByRole("region", { name: "First steps" })
    .getByText(/reference/)
    .waitFor();
  await shot("first_steps");
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.dismiss();
  await editor.settled();

  // On the map: a keytime where it was pressed.
  const menu = page.getByRole("menu");
  const box = await editor.canvas.boundingBox();
  const x = box.x + 72 + 0.4 * (box.width - 82);
  await page.mouse.click(x, box.y + 80, { button: "right" });
  await menu.waitFor();
  await shot("map");
  assert.deepEqual(await stumbles(editor), []);
  await editor.answered(() => menu.getByRole("menuitem", { name: /^Keytime at/ }).click());
  await until(() => editor.keys.count(), 1);
  await until(() => menu.isVisible(), false);
  await editor.settled();
  // On the keytime: what can be done with it; by the arrow keys as well.
  const key = editor.keys.first();
  await key.click({ button: "right" });
  await menu.getByRole("menuitem", { name: "Delete the keytime Del" }).waitFor();
  await shot("key");
  await editor.answered(() => menu.getByRole("menuitem", { name: "Hold there (0×)" }).click());
  await until(async () => /speed 0\.00/.test(await key.getAttribute("aria-label")), true);
  await key.click({ button: "right" });
  await page.keyboard.press("ArrowDown");
  await until(() => menu.locator(":focus").innerText(), "Go to it");
  await page.keyboard.press("Home");
  await editor.answered(() => page.keyboard.press("Enter"));
  await until(() => editor.keys.count(), 0);
  await editor.settled();

  // On the stage a click asks, a drag does not; what is on is ticked.
  const stage = page.locator(".stage canvas").last();
  const middle = await editor.centre(page.locator(".stage"));
  await page.mouse.move(middle.x + 90, middle.y);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(middle.x + 120, middle.y + 10, { steps: 3 });
  await page.mouse.up({ button: "right" });
  assert.equal(await menu.isVisible(), false);
  const turned = await editor.stage();
  await page.mouse.click(middle.x + 90, middle.y, { button: "right" });
  await until(() => menu.getByRole("menuitemcheckbox", { name: "Ground" }).getAttribute("aria-checked"), "true");
  await shot("stage");
  await menu.getByRole("menuitem", { name: "Reset the view" }).click();
  await editor.frames(4);
  assert.notEqual(await editor.stage(), turned);

  // As in Maya the left button alone turns nothing, with Alt it does; as in Blender the middle one does.
  const dragged = async (button, modifier) => {
    const was = await editor.stage();
    if (modifier) await page.keyboard.down(modifier);
    await page.mouse.move(middle.x + 60, middle.y);
    await page.mouse.down({ button });
    await page.mouse.move(middle.x + 130, middle.y + 15, { steps: 4 });
    await page.mouse.up({ button });
    if (modifier) await page.keyboard.up(modifier);
    await page.mouse.move(middle.x, middle.y - 100);
    await editor.frames(4);
    return (await editor.stage()) !== was;
  };
  const choose = async (name) => {
    await page.mouse.click(middle.x + 90, middle.y, { button: "right" });
    await menu.getByRole("menuitemcheckbox", { name: `Turn it as in ${name}` }).click();
    await editor.frames(2);
  };
  assert.equal(await dragged("left"), true);
  await choose("Maya");
  assert.equal(await dragged("left"), false);
  assert.equal(await dragged("left", "Alt"), true);
  await choose("Blender");
  assert.equal(await dragged("left"), false);
  assert.equal(await dragged("middle"), true);

  // On a section: what its buttons do.
  await page.getByRole("heading", { name: "References", exact: true }).click({ button: "right" });
  await menu.getByRole("menuitem", { name: "Imitate another clip too" }).waitFor();
  await page.keyboard.press("Escape");
  await until(() => menu.isVisible(), false);
  // The method says in a line what it does, and the paper's word where one points.
  const hint = page.getByText("Between your keytimes it moves as the reference does.");
  assert.match(await hint.getAttribute("title"), /guided time warping/);

  // Shortcuts stand in groups, and are found by a key or by what they do.
  await page.keyboard.press("?");
  const help = page.getByRole("dialog", { name: "Keyboard shortcuts" });
  assert.deepEqual(await help.getByRole("heading", { level: 4 }).allInnerTexts(), [
    "Playing",
    "Editing",
    "Looking",
    "Files and help",
    "By hand",
  ]);
  await until(() => help.getByLabel("Turn the stage as in").inputValue(), "blender");
  await shot("shortcuts");
  await help.getByLabel("Search shortcuts").fill("onion");
  await until(() => help.locator("dd:visible").allInnerTexts().then(String), "Onion skins");
  await help.getByLabel("Search shortcuts").fill("ctrl+s");
  await until(async () => (await help.locator("dd:visible").allInnerTexts()).includes("Save"), true);
  await help.getByLabel("Search shortcuts").fill("no such thing");
  await help.getByText("Nothing is called").waitFor();
  await help.getByLabel("Search shortcuts").fill("");
  assert.deepEqual(await stumbles(editor), []);
  await page.keyboard.press("Escape");

  // In the dark, and finely drawn.
  await page.getByRole("button", { name: "Dark theme" }).click();
  await page.mouse.click(x, box.y + 80, { button: "right" });
  await menu.waitFor();
  await shot("dark");
  assert.deepEqual(await stumbles(editor), []);
  await page.keyboard.press("Escape");
  await page.keyboard.press("?");
  await help.waitFor();
  await shot("shortcuts_dark");
  assert.deepEqual(await stumbles(editor), []);
  await page.keyboard.press("Escape");
  assert.equal(await stage.count(), 1);
  assert.deepEqual(editor.errors, []);
  console.log("{}");
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
