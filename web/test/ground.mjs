// Flights put right, a clip kept in step with a reference, an example carried over: in a real browser.
//
//     node ground.mjs '{"python": …, "clip": …, "reference": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: the warps that it exported and the documents that they answer, for the test to compare.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, reference, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, "--no-browser"];

const browser = await launch();
const server = await serve(command, folder, { XDG_STATE_HOME: state });
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  await page.getByRole("button", { name: "Got it" }).click();

  /** A picture in light and one in dark, and nothing in either that a screen reader's user would stumble over. */
  const look = async (name) => {
    for (const theme of ["light", "dark"]) {
      await editor.frames(4);
      await page.screenshot({ path: join(shots, `${name}_${theme}.png`) });
      assert.deepEqual(await stumbles(editor), [], `${name} ${theme}`);
      await page.getByRole("button", { name: theme === "light" ? "Dark theme" : "Light theme" }).click();
    }
  };
  const made = {};
  /** Save the project and export its warp; the test reads both. */
  const keep = async (name) => {
    await editor.settled();
    const paths = { project: join(folder, `${name}.retime`), warp: join(folder, `${name}.json`) };
    const write = async (keys, path, said) => {
      await page.keyboard.press(keys);
      const dialog = page.getByRole("dialog");
      if (said === "Wrote") await dialog.getByLabel("What", { exact: true }).selectOption("warp");
      await dialog.getByLabel("Path", { exact: true }).fill(path);
      await dialog.getByRole("button", { name: "Write", exact: true }).click();
      await page.getByText(`${said} ${path}`).waitFor({ timeout: 60_000 });
    };
    await write("Control+Shift+s", paths.project, "Saved");
    await write("Control+e", paths.warp, "Wrote");
    made[name] = paths;
  };
  const undo = async (step) => {
    await page.getByRole("button", { name: `Undo ${step} (Ctrl+Z)` }).waitFor();
    await editor.answered(() => page.getByRole("button", { name: `Undo ${step} (Ctrl+Z)` }).click());
    // The curve may come before the document: what is done next is done to that.
    await page.getByRole("button", { name: `Redo ${step} (Ctrl+Shift+Z)` }).waitFor();
  };

  // What was found: a band each beside the feet, and a row each at the right.
  const flights = page.locator("button.handle.flight");
  const names = () => flights.evaluateAll((bands) => bands.map((band) => band.getAttribute("aria-label")).sort());
  await editor.setField("Length", "60%");
  const found = await names();
  assert.ok(found.length >= 2);
  for (const name of found) assert.match(name, /^Flight \d+: in the air from input [\d.]+ to [\d.]+ s, found$/);
  assert.equal(await page.getByRole("textbox", { name: "Flight from" }).count(), found.length);
  const end = page.getByRole("slider", { name: "End of flight 1", exact: true });
  const before = Number(await end.getAttribute("aria-valuenow"));

  // An end is moved by the keyboard: the flight that was found gives way, and keeps its place under the hand.
  await end.focus();
  await editor.answered(() => page.keyboard.press("Shift+ArrowLeft"));
  assert.ok(Number(await end.getAttribute("aria-valuenow")) < before - 0.1);
  assert.match((await names())[0], /said by hand$/);
  assert.ok(await end.evaluate((handle) => handle === document.activeElement));
  await undo("change flight");
  await until(async () => (await names()).join(), found.join());
  await page.keyboard.press("Control+Shift+z");
  await until(async () => (await names())[0].endsWith("said by hand"), true);

  // It is dragged too, and stays in the hand while it becomes one that a person has marked.
  const second = page.getByRole("slider", { name: "Beginning of flight 2", exact: true });
  const from = await editor.centre(second);
  const start = Number(await second.getAttribute("aria-valuenow"));
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 4; i++) await editor.answered(() => page.mouse.move(from.x - 3 * i, from.y));
  await page.mouse.up();
  await page.getByRole("button", { name: "Undo change flight (Ctrl+Z)" }).waitFor();
  assert.ok(Number(await second.getAttribute("aria-valuenow")) < start);
  // Let go, it is one step, on the disk: the same name may be that of the step before.
  await editor.settled();
  await undo("change flight");

  // Denied, and said to be none; Why says so where it is.
  const band = page.getByRole("button", { name: /^Flight 2: / });
  await band.focus();
  await editor.answered(() => page.keyboard.press("Delete"));
  await page.getByRole("button", { name: /^Flight 2: not in the air from input .*, said by hand$/ }).waitFor();
  const box = await editor.canvas.boundingBox();
  const denied = await editor.centre(flights.and(page.locator(".denied")));
  await editor.openWhy();
  await page.mouse.move(denied.x, box.y + 60);
  const why = page.getByLabel("Why", { exact: true });
  await why.getByText(/^not in the air from input/).waitFor();

  // A stretch along the feet is marked by hand.
  const feet = (await editor.centre(flights.first())).y;
  await page.mouse.move(box.x + 130, feet);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(box.x + 160, feet, { steps: 3 }));
  await page.mouse.up();
  await page.getByRole("button", { name: "Undo add flight (Ctrl+Z)" }).waitFor();
  assert.equal(await flights.count(), found.length + 1);
  // And typed: what can't be is said at once. (A curve that comes would bring the old value back.)
  await editor.settled();
  const typed = page.getByRole("textbox", { name: "Flight from" }).first();
  await typed.fill("1:75");
  await typed.press("Enter");
  assert.equal(await typed.getAttribute("aria-invalid"), "true");
  await typed.press("Escape");
  // The list is sorted by its heads as all lists are: what is denied comes last, and first.
  const flying = () =>
    page.getByRole("checkbox", { name: "In the air" }).evaluateAll((boxes) => boxes.map((box) => box.checked));
  await page.locator("section[aria-label=Flights]").getByRole("button", { name: "Sort by in the air" }).click();
  assert.deepEqual(await flying(), [...Array(found.length).fill(true), false]);
  await page
    .locator("section[aria-label=Flights]")
    .getByRole("button", { name: /^Sort by in the air/ })
    .click();
  assert.deepEqual(await flying(), [false, ...Array(found.length).fill(true)]);
  await page.locator("section[aria-label=Flights]").getByRole("button", { name: "Sort by from" }).click();
  await page.mouse.move(denied.x, box.y + 60);
  await page.locator("section[aria-label=Flights]").scrollIntoViewIfNeeded();
  await look("flights");
  await keep("flights");

  // In step with a reference: where there is none, that is said beside the method, and on the map.
  const method = page.getByLabel("Method", { exact: true });
  await method.selectOption({ label: "Synchronise" });
  await page
    .locator("section[aria-label=Search] .refused")
    .filter({ hasText: "there is nothing to keep step with" })
    .waitFor();
  assert.equal(await method.getAttribute("aria-invalid"), "true");
  await method.scrollIntoViewIfNeeded();
  await look("align_without");
  await page.getByRole("button", { name: "File…", exact: true }).click();
  await editor.answered(() => page.getByRole("dialog").getByRole("button", { name: reference, exact: true }).click());
  await until(() => method.getAttribute("aria-invalid"), null);
  await editor.setField("Repeat", "1.5");
  // What the reference's clock leaves no room for is hidden; what holds is there.
  for (const label of ["Length", "Evenness", "Keep jumps", "Loop: its end meets its beginning", "Score"])
    assert.equal(await page.getByLabel(label, { exact: true }).isVisible(), false, label);
  for (const label of ["Influence", "Smoothness", "Speed limits", "Search rate", "Pose"])
    assert.equal(await page.getByLabel(label, { exact: true }).isVisible(), true, label);
  assert.equal(await page.getByRole("slider", { name: "End of the output" }).isVisible(), false);
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.4 * box.height, { steps: 3 });
  await why.getByText(/^\S+ at [\d.]+ s$/).waitFor();
  await method.scrollIntoViewIfNeeded();
  await look("align");
  await keep("align");
  await method.selectOption({ label: "Guided" });
  await page.getByLabel("Length", { exact: true }).waitFor();
  assert.equal(await page.getByLabel("Repeat", { exact: true }).isVisible(), false);
  // The length that was given before holds again.
  assert.equal(await page.getByLabel("Length", { exact: true }).inputValue(), "60%");
  await page.getByRole("button", { name: /^Remove / }).click();
  await editor.setField("Length", "");

  // Propagated: a stretch retimed by hand is the example.
  const propagate = page.locator("section[aria-label=Propagate]");
  const go = propagate.getByRole("button", { name: "Propagate", exact: true });
  assert.equal(await go.isDisabled(), true);
  for (const [share, input, output] of [
    [0.2, "2", "2"],
    [0.35, "3.5", "4.5"],
  ]) {
    await editor.addKey(share);
    await editor.setField("Output at", output);
    await editor.setField("Shows input", input);
  }
  await propagate.getByText("Input 2.00 to 3.50 s was retimed by hand; the rest follows.").waitFor();
  await editor.answered(() => go.click());
  await propagate.getByText(/^The example speaks for \d+ % of the clip\./).waitFor();
  await propagate.getByRole("list", { name: "What to look at" }).getByRole("listitem").first().waitFor();
  await editor.setField("Example to", "3.4");
  await page.mouse.move(box.x + 0.35 * box.width, box.y + 0.4 * box.height, { steps: 3 });
  await why.getByText("Example", { exact: true }).waitFor();
  // What was matched lies in the example.
  await why.getByText(/^itself at [23]\.\d\d, /).waitFor();
  await propagate.scrollIntoViewIfNeeded();
  await look("propagate");
  await keep("propagate");
  await editor.settled();
  const key = page.getByLabel("Example from", { exact: true });
  await key.fill("9");
  await key.press("Enter");
  assert.equal(await key.getAttribute("aria-invalid"), "true");
  await key.press("Escape");
  await editor.answered(() => propagate.getByRole("button", { name: "Stop propagating" }).click());
  await go.waitFor();
  await undo("stop propagating");
  await propagate.getByText(/^The example speaks for \d+ % of the clip\./).waitFor();

  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify(made));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
