// The editor in a real browser, from opening a clip to comparing its export; run by tests/server/test_browser.py.
//
//     node browser.mjs '{"python": …, "clip": …, "options": […], "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: what it found, for the test to compare with the command line's.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, options, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, ...options, "--no-browser"];
const start = () => serve(command, folder, { XDG_STATE_HOME: state });

const browser = await launch();
let server = await start();
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });

  // The token is gone from the address, and the first steps are shown once.
  assert.equal(new URL(page.url()).search, "");
  await shot("first_run");
  await page.getByRole("button", { name: "Got it" }).click();

  // A length, a keytime.
  await editor.setField("Length", "65%");
  const key = await editor.addKey(0.45);
  const firstLabel = await key.getAttribute("aria-label");
  assert.match(firstLabel, /^Keytime 1 of 1: input [\d.]+ s at output [\d.]+ s$/);

  // Dragged, it changes what is shown at another time; the curve follows while it is held.
  await editor.scrub(0.3);
  const before = {
    input: await editor.readout("input"),
    output: await editor.readout("output"),
    stage: await editor.stage(),
  };
  const from = await editor.centre(key);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 8; i++) await editor.answered(() => page.mouse.move(from.x + 7 * i, from.y));
  await editor.changed("input", before.input);
  await shot("dragging");
  await editor.answered(() => page.mouse.up());
  await editor.settled();
  const after = { input: await editor.readout("input"), output: await editor.readout("output") };
  const movedLabel = await key.getAttribute("aria-label");
  assert.equal(after.output, before.output);
  assert.notEqual(after.input, before.input);
  assert.notEqual(movedLabel, firstLabel);
  // The pointer rests on the map and would show the frame under it.
  await page.mouse.move(from.x, from.y - 400);
  await editor.frames(3);
  assert.notEqual(await editor.stage(), before.stage);

  // One drag is one step to undo, and to redo.
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => key.getAttribute("aria-label"), firstLabel);
  await until(() => editor.readout("input"), before.input);
  await editor.answered(() => page.keyboard.press("Control+Shift+z"));
  await until(() => key.getAttribute("aria-label"), movedLabel);
  await until(() => editor.readout("input"), after.input);

  // By keyboard alone: a frame later, and back.
  await key.focus();
  await editor.answered(() => page.keyboard.press("ArrowRight"));
  assert.notEqual(await key.getAttribute("aria-label"), movedLabel);
  await editor.answered(() => page.keyboard.press("ArrowLeft"));
  await until(() => key.getAttribute("aria-label"), movedLabel);

  // Why: a frame under the pointer has a score and a matched pose, which lies on the stage as a ghost.
  const box = await editor.canvas.boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.75 * box.height, { steps: 3 });
  await page.locator(".caption[data-is=reference]").waitFor();
  await editor.openWhy();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.75 * box.height, { steps: 3 });
  const why = await page.getByLabel("Why", { exact: true }).innerText();
  assert.match(why, /Score\s+[\d.e+]+, /);
  assert.match(why, /Matched\s+\S+ at [\d.]+/);
  await shot("why");

  // What can't be done is said beside the key, and the curve stays.
  const kept = await editor.readout("input");
  await key.focus();
  const output = page.getByLabel("Output at", { exact: true });
  await output.fill("0.01");
  await output.press("Enter");
  const trouble = page.locator(".trouble");
  await trouble.waitFor({ timeout: 30_000 });
  assert.ok((await trouble.innerText()).length > 20);
  assert.ok(await key.evaluate((element) => element.classList.contains("faulty")));
  await until(() => editor.readout("input"), kept);
  await shot("problem");
  await output.blur();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await trouble.waitFor({ state: "hidden" });
  await until(() => key.getAttribute("aria-label"), movedLabel);

  // A warp is kept, and compared with: B plays it instead.
  await page.getByRole("button", { name: "Keep" }).click();
  await page.getByLabel("Beside it", { exact: true }).selectOption({ label: "Version 1" });
  await page.getByRole("button", { name: "B Version 1" }).click();
  await page.getByText("Output, Version 1").waitFor();
  await page.getByLabel("Beside it", { exact: true }).selectOption({ label: "Input" });

  // A lock, drawn along the input times; taken back.
  await page.mouse.move(box.x + 40, box.y + 90);
  await page.mouse.down();
  await editor.answered(() => page.mouse.move(box.x + 40, box.y + 70, { steps: 3 }));
  await page.mouse.up();
  await page.locator(".handle.band").waitFor();
  await shot("lock");
  await page.keyboard.press("Control+z");
  await page.locator(".handle.band").waitFor({ state: "detached" });

  // Both layouts, everything shown; light and dark, and finely drawn.
  await page.getByRole("button", { name: "Trails" }).click();
  await page.getByRole("button", { name: "Onion skins" }).click();
  await page.getByRole("button", { name: "Overlaid" }).click();
  await editor.frames(4);
  await shot("overlaid");
  const light = await stumbles(editor);
  await page.getByRole("button", { name: "Dark theme" }).click();
  await editor.frames(4);
  await shot("dark");
  const dark = await stumbles(editor);
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keyboard shortcuts" }).waitFor();
  await shot("shortcuts");
  const help = await stumbles(editor);
  await page.keyboard.press("Escape");
  assert.deepEqual([...light, ...dark, ...help], []);
  await page.getByRole("button", { name: "Light theme" }).click();

  // The server dies; another one brings back all that was done.
  server.process.kill("SIGKILL");
  await server.ended;
  await page.locator(".veil").waitFor();
  const errors = [...editor.errors];
  // Left open, this page could find the new server by itself, and be told in the next one's place.
  await page.goto("about:blank");
  server = await start();
  await page.goto(server.address);
  await editor.ready();
  await page.getByText("Everything that was done is back").waitFor();
  await editor.dismiss();
  await key.waitFor();
  await until(() => key.getAttribute("aria-label"), movedLabel);
  // Another run, the same person: the first steps are not shown again.
  assert.equal(await page.getByRole("button", { name: "Got it" }).isVisible(), false);
  await editor.scrub(0.3);
  await until(() => editor.readout("input"), after.input);
  await shot("recovered");

  // Saved to a file of its own.
  const project = join(folder, "work.retime");
  await page.keyboard.press("Control+s");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(project);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Saved ${project}`).waitFor();
  await page.locator(".project").getByText("saved", { exact: true }).waitFor();

  // Exported, for the test to compare with what the command line writes.
  const exported = join(folder, `exported${clip.slice(clip.lastIndexOf("."))}`);
  await page.keyboard.press("Control+e");
  await shot("export");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(exported);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Wrote ${exported}`).waitFor({ timeout: 60_000 });

  // The same warp for another program; what can be named and numbered is that program's.
  const curve = join(folder, "curve.nk");
  await page.keyboard.press("Control+e");
  const dialog = page.getByRole("dialog");
  const field = (name) => dialog.getByLabel(name, { exact: true });
  await field("What").selectOption({ label: "Retime curve for another program" });
  await field("Program").selectOption({ label: "Lottie, a precomposition with a time remap" });
  assert.equal(await field("First frame").isVisible(), false);
  assert.equal(await field("Tolerance").isVisible(), true);
  assert.match(await field("Path").inputValue(), /_retime\.json$/);
  await field("Program").selectOption({ label: "Nuke, a TimeWarp node" });
  assert.equal(await field("Tolerance").isVisible(), false);
  await field("Rate").fill("24");
  await field("First frame").fill("1001");
  await field("For").fill("Shot12");
  assert.match(await field("Path").inputValue(), /_retime\.nk$/);
  // What was typed as a path stays, whatever is named after it.
  await field("Path").fill("own.nk");
  await field("For").fill("Shot13");
  await field("For").press("Tab");
  assert.equal(await field("Path").inputValue(), "own.nk");
  await field("For").fill("Shot12");
  await shot("curve");
  const seen = await stumbles(editor);
  await field("Path").fill(curve);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Wrote ${curve}: off by under 0.000001 frames`).waitFor({ timeout: 60_000 });
  // What a program can't play is told.
  await page.keyboard.press("Control+e");
  await field("First frame").fill("soon");
  await field("Path").fill(join(folder, "not.nk"));
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await dialog.getByText("expected the first frame's number").waitFor();
  assert.equal(await field("Path").inputValue(), join(folder, "not.nk"));
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "hidden" });
  assert.deepEqual(seen, []);

  // References: another file, and the clip itself; listed, weighed, ranged and mapped, and taken back.
  const listed = () => page.getByRole("group", { name: "References" }).locator(".pick").allInnerTexts();
  assert.deepEqual(await listed(), ["The clip itself"]);
  await page.getByRole("button", { name: "File…", exact: true }).click();
  await editor.answered(() => page.getByRole("dialog").getByRole("button", { name: "other.bvh" }).click());
  await until(async () => (await listed()).join(), "other");
  await editor.answered(() => page.getByRole("button", { name: "Itself", exact: true }).click());
  await until(async () => (await listed()).join(), "other,The clip itself");
  await editor.setField("Weight", "2");
  await editor.setField("Reference to", "1.5");
  const reach = page.getByRole("slider", { name: "Last frame of the reference that is imitated" });
  await until(() => reach.getAttribute("aria-valuetext"), "1.50 s");
  await editor.settled();
  await shot("references");
  await page.getByLabel("Reference shown", { exact: true }).selectOption({ label: "other" });
  await until(() => page.getByLabel("Weight", { exact: true }).inputValue(), "1");
  await page.getByRole("button", { name: /of \d+ matched$/ }).click();
  const [joint] = await page.locator(".joints select").all();
  const automatic = (await joint.locator("option").first().innerText()).replace(/, by name.*/, "");
  const another = await joint.locator("option").evaluateAll(
    (options, not) =>
      options
        .map((option) => option.value)
        .filter((value) => value !== "" && value !== not)
        .at(-1),
    automatic,
  );
  await joint.selectOption(another);
  await until(() => joint.evaluate((select) => select.closest(".row").dataset.is), "said");
  await shot("joints");
  assert.deepEqual(await stumbles(editor), []);
  await page.getByRole("button", { name: "Done" }).click();
  const steps = [
    "change joint map",
    "choose reference range",
    "set reference weight",
    "add reference",
    "add reference",
  ];
  for (const step of steps) {
    await page.getByRole("button", { name: `Undo ${step}` }).waitFor();
    await page.keyboard.press("Control+z");
  }
  await until(async () => (await listed()).join(), "The clip itself");
  await editor.settled();

  // A file that the editor may not use: the dialog says what to type.
  await page.keyboard.press("Control+o");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill("/etc/walk.bvh");
  await page.getByRole("dialog").getByRole("button", { name: "Open", exact: true }).click();
  await page
    .getByRole("alert")
    .filter({ hasText: /type: retime edit .* --folder \/etc$/ })
    .waitFor();
  await shot("refused");
  await page.getByRole("button", { name: "Cancel" }).click();

  // The notebook's bundle shows the same where its messages travel another way.
  const notebook = await page.context().newPage();
  const widget = new Editor(notebook);
  await notebook.goto(new URL("/health", page.url()).href);
  await notebook.evaluate(async () => {
    const { default: bundle } = await import("/widget.js");
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    await new Promise((resolve) => socket.addEventListener("open", resolve));
    const model = {
      get: () => 600,
      send: (content) => socket.send(JSON.stringify(content)),
      on: (_, heard) =>
        socket.addEventListener("message", ({ data }) =>
          typeof data === "string" ? heard(JSON.parse(data), []) : heard({}, [new DataView(data)]),
        ),
      off: () => undefined,
    };
    const style = Object.assign(document.createElement("link"), { rel: "stylesheet", href: "/widget.css" });
    document.head.append(style);
    bundle.render({ model, el: document.body });
  });
  await widget.keys.first().waitFor();
  await widget.ready();
  await until(() => widget.keys.first().getAttribute("aria-label"), movedLabel);
  // That bare document has no icon.
  assert.deepEqual(
    widget.errors.filter((error) => !error.includes("404")),
    [],
  );
  await widget.frames(6);
  // Its style sheet came after it: the timeline is drawn in the theme's colours, not in black.
  const corner = await widget.canvas.evaluate((canvas) => [...canvas.getContext("2d").getImageData(2, 2, 1, 1).data]);
  assert.notDeepEqual(corner, [0, 0, 0, 255]);
  await notebook.screenshot({ path: join(shots, "widget.png") });
  await notebook.close();

  // A file that is dropped is opened.
  await page.evaluate(() => {
    const transfer = new DataTransfer();
    transfer.items.add(
      new File(
        [`time,a,b\n${Array.from({ length: 90 }, (_, i) => `${(i / 30).toFixed(6)},${i % 7},${i}`).join("\n")}`],
        "dropped.csv",
      ),
    );
    document
      .querySelector(".retime")
      .dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
  });
  await page.getByRole("img", { name: "Stage: the channels of dropped as curves" }).waitFor({ timeout: 30_000 });
  await shot("dropped");

  // A browser without the cookie is not let in.
  const stranger = await (await browser.newContext()).newPage();
  assert.equal((await stranger.goto(page.url()))?.status(), 403);

  assert.deepEqual(errors, []);
  assert.deepEqual(
    [...editor.hosts].filter((host) => !/^127\.0\.0\.1:\d+$/.test(host)),
    [],
  );
  console.log(JSON.stringify({ project, exported, curve, key: movedLabel, before: before.input, after: after.input }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
