// Keytimes chosen together, in a real browser: box, Shift, moved, scaled, nudged, rippled, copied, listed, deleted.
//
//     node choosing.mjs '{"python": …, "clip": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the keytimes of the project that it saved.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, "--no-browser"];

const browser = await launch();
const server = await serve(command, folder, { XDG_STATE_HOME: state });
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();

  /** Input and output times of all keytimes, as their labels say them, in the order of the output. */
  const times = async () => {
    const labels = await editor.keys.evaluateAll((keys) => keys.map((key) => key.getAttribute("aria-label")));
    return labels
      .map((label) => /input ([\d.]+) s at output ([\d.]+) s/.exec(label).slice(1).map(Number))
      .sort((a, b) => a[1] - b[1]);
  };
  const chosen = () => page.locator('button.handle.key[aria-pressed="true"]').count();
  const key = (n) => page.getByRole("button", { name: new RegExp(`^Keytime ${n} of `) });
  const heading = (text) => page.getByRole("heading", { name: text, exact: true }).waitFor();
  const undo = async (label) => {
    await page.getByRole("button", { name: `Undo ${label}` }).waitFor();
    await editor.answered(() => page.keyboard.press("Control+z"));
    await editor.settled();
  };
  const drag = async (from, dx, dy, { held } = {}) => {
    await page.mouse.move(from.x, from.y);
    if (held) await page.keyboard.down(held);
    await page.mouse.down();
    for (let i = 1; i <= 4; i++) await page.mouse.move(from.x + (dx * i) / 4, from.y + (dy * i) / 4);
    await page.mouse.up();
    if (held) await page.keyboard.up(held);
  };
  const near = (found, expected, by = 1e-9) =>
    assert.ok(Math.abs(found - expected) <= by, `${found} is not ${expected}, give or take ${by}`);
  const frame = 1 / 60;

  await editor.setField("Length", "65%");
  for (const share of [0.2, 0.4, 0.6]) await editor.addKey(share);
  await editor.settled();
  const made = await times();
  assert.equal(made.length, 3);

  // A keytime just made leaves the arrows to the playhead.
  await editor.scrub(0.8);
  await editor.answered(() => page.keyboard.press("i"));
  await key(4).waitFor();
  await page.keyboard.press("ArrowRight");
  const four = await times();
  assert.equal(four.length, 4);
  await until(() => editor.frame("output"), Math.round(four[3][1] / frame) + 1);
  assert.deepEqual(await times(), four);
  // It is what is selected: Alt and the arrows move it, wherever the focus is.
  await editor.answered(() => page.keyboard.press("Alt+ArrowRight"));
  near((await times())[3][1], four[3][1] + frame, 0.0011);
  await editor.answered(() => page.keyboard.press("Alt+ArrowUp"));
  near((await times())[3][0], four[3][0] + frame, 0.0011);
  await until(() => editor.frame("output"), Math.round(four[3][1] / frame) + 1);
  await editor.answered(() => page.keyboard.press("Delete"));
  await until(async () => (await times()).length, 3);

  // A box chooses; Shift adds and takes away; a click chooses one, or puts the playhead there.
  const [first, second] = [await editor.centre(key(1)), await editor.centre(key(2))];
  const corner = { x: first.x - 18, y: first.y + 18 };
  await drag(corner, second.x + 18 - corner.x, second.y - 18 - corner.y);
  await until(chosen, 2);
  await heading("2 keytimes");
  await shot("chosen");
  assert.deepEqual(await stumbles(editor), []);
  await key(3).click({ modifiers: ["Shift"] });
  await until(chosen, 3);
  await key(3).click({ modifiers: ["Shift"] });
  await until(chosen, 2);
  await key(3).click();
  await until(chosen, 1);
  await key(1).click({ modifiers: ["Shift"] });
  await until(chosen, 2);
  await drag(corner, second.x + 18 - corner.x, second.y - 18 - corner.y, { held: "Shift" });
  await until(chosen, 3);
  await page.keyboard.press("Control+a");
  await until(chosen, 3);
  const map = await editor.canvas.boundingBox();
  await page.mouse.click(map.x + 110, map.y + 50);
  await until(chosen, 0);
  await drag(corner, second.x + 18 - corner.x, second.y - 18 - corner.y);
  await until(chosen, 2);

  // Dragged by one of them they move as one, and that is one step to undo.
  await drag(first, 24, 0);
  await editor.settled();
  const moved = await times();
  const by = moved[0][1] - made[0][1];
  assert.ok(by > 3 * frame);
  near(moved[1][1] - made[1][1], by, 0.0011);
  assert.deepEqual(moved[2], made[2]);
  assert.equal(await chosen(), 2);
  await undo("move keys");
  assert.deepEqual(await times(), made);

  // A side of their frame scales them about the other one; typed, all of it can be said.
  const side = page.getByRole("slider", { name: "Scale the chosen keytimes' output times about the first" });
  await drag(await editor.centre(side), -30, 0);
  await editor.settled();
  const scaled = await times();
  assert.deepEqual(scaled[0], made[0]);
  assert.ok(scaled[1][1] < made[1][1] - 3 * frame);
  assert.deepEqual(scaled[2], made[2]);
  await undo("scale keys");
  await side.focus();
  await editor.answered(() => page.keyboard.press("ArrowLeft"));
  near((await times())[1][1], made[1][1] - frame, 0.0011);
  await undo("scale keys");
  await editor.setField("Begin at", "30f");
  near((await times())[0][1], 0.5, 0.0011);
  near((await times())[1][1] - (await times())[0][1], made[1][1] - made[0][1], 0.0011);
  await editor.setField("Last", "60f");
  near((await times())[1][1], 1.5, 0.0011);
  await undo("scale keys");
  await undo("move keys");
  assert.deepEqual(await times(), made);

  // Copied, and pasted at the playhead: the same timing from the pose that is shown there.
  await page.keyboard.press("Control+c");
  await editor.scrub(0.68);
  await editor.answered(() => page.keyboard.press("Control+v"));
  await until(async () => (await times()).length, 5);
  const pasted = await times();
  assert.equal(await chosen(), 2);
  near(pasted[4][1] - pasted[3][1], made[1][1] - made[0][1], 0.0011);
  near(pasted[4][0] - pasted[3][0], made[1][0] - made[0][0], 0.0011);
  await page.locator(".trouble").waitFor({ state: "hidden" });
  // Cut they are gone; at their own times they come back.
  await editor.answered(() => page.keyboard.press("Control+x"));
  await until(async () => (await times()).length, 3);
  await editor.answered(() => page.keyboard.press("Control+Shift+v"));
  await until(async () => JSON.stringify(await times()), JSON.stringify(pasted));
  await undo("paste keys");
  await undo("cut keys");
  await undo("paste keys");
  // What is no keytime is said to be none.
  await page.evaluate(() => {
    const clipboardData = new DataTransfer();
    clipboardData.setData("text/plain", "hello");
    document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
  });
  await page.getByText("What was copied is no keytime: expected input time = output time").waitFor();
  await editor.dismiss();
  assert.deepEqual(await times(), made);

  // Ripple: what follows moves along, the end of the output too.
  const end = page.getByRole("slider", { name: "End of the output" });
  const endBefore = Number.parseFloat(await end.getAttribute("aria-valuetext"));
  await page.getByLabel("Ripple", { exact: true }).check();
  await drag(await editor.centre(key(2)), 24, 0);
  await editor.settled();
  const rippled = await times();
  const along = rippled[1][1] - made[1][1];
  assert.ok(along > 3 * frame);
  assert.deepEqual(rippled[0], made[0]);
  near(rippled[2][1] - made[2][1], along, 0.0011);
  near(rippled[2][0], made[2][0]);
  near(Number.parseFloat(await end.getAttribute("aria-valuetext")) - endBefore, along, 0.0021);
  await shot("rippled");
  await undo("move key");
  assert.deepEqual(await times(), made);
  await page.keyboard.press("r");
  assert.equal(await page.getByLabel("Ripple", { exact: true }).isChecked(), false);

  // Whatever the mouse has used gives the keys back, and who came by the keyboard goes on by it.
  const ripple = page.getByLabel("Ripple", { exact: true });
  const pause = page.getByRole("button", { name: "Pause (Space)", exact: true });
  await page.getByText("Ripple", { exact: true }).click();
  await page.keyboard.press("Space");
  await pause.waitFor();
  assert.equal(await ripple.isChecked(), true);
  await page.keyboard.press("Space");
  await pause.waitFor({ state: "hidden" });
  const influence = page.getByLabel("Influence", { exact: true });
  const knob = await influence.boundingBox();
  const share = await influence.inputValue();
  await page.mouse.click(knob.x + knob.width / 2, knob.y + knob.height / 2);
  await page.keyboard.press("ArrowLeft");
  assert.equal(await page.evaluate(() => document.activeElement?.matches("input")), false);
  await undo("set influence");
  await until(() => influence.inputValue(), share);
  await ripple.press("Space");
  assert.equal(await ripple.isChecked(), false);
  assert.ok(await ripple.evaluate((box) => box === document.activeElement));
  await page.keyboard.press("Space");
  assert.equal(await ripple.isChecked(), true);
  await ripple.press("Space");
  await ripple.blur();

  // The list: sorted by its heads, edited and deleted in place.
  await page.getByText("All 3 keytimes", { exact: true }).click();
  const outputs = () =>
    page.getByLabel("Keytime's output").evaluateAll((fields) => fields.map((field) => Number(field.value)));
  const inOrder = made.map(([, output]) => output);
  await until(async () => JSON.stringify(await outputs()), JSON.stringify(inOrder));
  await page.getByRole("button", { name: /^Sort by output/ }).click();
  assert.deepEqual(await outputs(), made.map(([, output]) => output).reverse());
  await page.getByRole("button", { name: "Sort by speed" }).click();
  const speed = page.getByLabel("Keytime's speed").last();
  await editor.answered(async () => {
    await speed.fill("1/2");
    await speed.press("Enter");
  });
  await speed.blur();
  await page.getByRole("button", { name: /^Sort by speed/ }).click();
  await until(() => page.getByLabel("Keytime's speed").first().inputValue(), "0.5");
  await shot("listed");
  assert.deepEqual(await stumbles(editor), []);
  await editor.answered(() => page.getByRole("button", { name: "Delete this keytime" }).first().click());
  await until(async () => (await times()).length, 2);
  await editor.answered(() => page.keyboard.press("Control+z"));
  await undo("set speed at key");
  assert.deepEqual(await times(), made);

  // Locks are sorted in the same way.
  const box = await editor.canvas.boundingBox();
  for (const [from, to] of [
    [60, 45],
    [110, 90],
  ]) {
    await editor.answered(() => drag({ x: box.x + 40, y: box.y + from }, 0, to - from));
    await editor.settled();
  }
  const begins = () => page.getByLabel("Lock from").evaluateAll((fields) => fields.map((field) => Number(field.value)));
  const [low, high] = await begins();
  assert.ok(low < high);
  const locked = page.locator('section[aria-label="Locked spans"]');
  await locked.getByRole("button", { name: /^Sort by from/ }).click();
  assert.deepEqual(await begins(), [high, low]);
  await undo("add lock");
  await undo("add lock");

  // Many at once: chosen, and deleted in one step.
  await page.keyboard.press("Control+a");
  await editor.answered(() => page.keyboard.press("Delete"));
  await until(async () => (await times()).length, 0);
  await undo("delete keys");
  assert.deepEqual(await times(), made);

  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify({ keys: made }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
