// What the page edits beside keys, in a real browser: groups and their references, channels, bounds, and what is refused.
//
//     node fields.mjs '{"python": …, "clips": […], "wide": …, "counterpart": …, "project": …, "folder": …, "state": …, "shots": …,
//         "options": […]}'
//
// Prints one JSON object: the document that it made, for the test to compare with the library's.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clips, wide, counterpart, project, elsewhere, folder, state, shots, options } = JSON.parse(
  process.argv[2],
);
const begin = (...names) =>
  serve([python, "-m", "retime.cli.main", "edit", ...names, "--no-browser"], folder, { XDG_STATE_HOME: state });

const browser = await launch();
let server = await begin(...clips, wide);
try {
  const editor = await Editor.open(browser, server.address, { dark: true });
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();

  // Each figure of the group has a colour of its own, named by its tab; a signal has none.
  const tabs = page.getByRole("group", { name: "Clips" });
  const colours = await tabs
    .locator(".dot")
    .evaluateAll((dots) => dots.map((dot) => getComputedStyle(dot).backgroundColor));
  assert.equal(new Set(colours).size, 2);
  await shot("group");

  // Of a signal with many channels any can be seen.
  await tabs.getByRole("button", { name: "wide" }).click();
  await page.getByText("8 of 20 channels").click();
  await page.getByRole("button", { name: "None", exact: true }).click();
  await page.getByText("0 of 20 channels").waitFor();
  const listed = page.getByRole("group", { name: "Channels shown" });
  for (const name of ["c17", "c3"]) await listed.getByLabel(name, { exact: true }).check();
  await page.getByText("2 of 20 channels").waitFor();
  await shot("channels");
  assert.deepEqual(await stumbles(editor), []);
  await page.getByRole("button", { name: "All", exact: true }).click();
  const rows = page.locator(".signals");
  await until(() => rows.evaluate((view) => view.scrollHeight > view.clientHeight), true);
  await page.keyboard.press("Escape");
  await until(() => listed.isVisible(), false);
  const drawn = () => rows.locator("canvas").evaluate((canvas) => canvas.toDataURL());
  const above = await drawn();
  await rows.evaluate((view) => (view.scrollTop = view.scrollHeight));
  await editor.frames(4);
  assert.notEqual(await drawn(), above);

  // Every option of the search has its row, and the row says what the declaration says.
  const more = page.locator("summary").filter({ hasText: "More" });
  await more.click();
  const declared = page.locator("section[aria-label=Timing], section[aria-label=Search]");
  for (const option of options) {
    const control = declared.getByLabel(option.label, { exact: true });
    assert.equal(await control.count(), 1, option.label);
    assert.equal(await control.isVisible(), !option.needs_free, option.label);
    const shown = await control.evaluate((input) => ({
      title: (input.closest("[title]") ?? input).title,
      tag: input.tagName,
      type: input.type,
      value: input.value,
      checked: input.checked,
      placeholder: input.placeholder,
      range: [input.min, input.max, input.step].map(Number),
      choices: input.options && [...input.options].map((one) => [one.value, one.text]),
      panel: input.closest("details") ? "more" : input.closest("section").ariaLabel.toLowerCase(),
    }));
    assert.ok(shown.title.startsWith(option.hint), shown.title);
    assert.ok(shown.title.includes(option.flag), shown.title);
    assert.equal(shown.panel, option.panel, option.label);
    if (option.slider) {
      assert.deepEqual([shown.type, shown.range], ["range", [0, ...option.slider]]);
      const value = option.curve === "square" ? Number(shown.value) ** 2 : Number(shown.value);
      // Where the default depends on the clip, the row shows what the search used: for a figure the first that is named.
      assert.equal(value, option.default ?? Number.parseFloat(option.usual), option.label);
    } else if (option.kind === "flag") {
      assert.deepEqual([shown.type, shown.checked], ["checkbox", option.default]);
    } else if (option.kind === "choice") {
      const open = option.default === null;
      assert.deepEqual(shown.choices, [...(open ? [["", "Default"]] : []), ...option.choices]);
      assert.equal(shown.value, option.default ?? "");
      assert.ok(!open || shown.title.includes(`Default: ${option.usual}.`), shown.title);
    } else {
      assert.deepEqual([shown.tag, shown.value, shown.placeholder], ["INPUT", "", option.in_short]);
      assert.ok(shown.title.includes(`Empty: ${option.usual}.`), shown.title);
      // What lies beyond a bound is refused as it is typed.
      const beyondBounds = [
        ...(option.least === null ? [] : [option.least - 1]),
        ...(option.most === null ? [] : [option.most + 1]),
      ];
      for (const beyond of beyondBounds) {
        await control.fill(String(beyond));
        await control.press("Enter");
        assert.equal(await control.getAttribute("aria-invalid"), "true", `${option.label} ${beyond}`);
        await control.press("Escape");
        await until(() => control.getAttribute("aria-invalid"), null);
        assert.equal(await control.inputValue(), "", `${option.label} ${beyond}`);
      }
    }
  }
  await more.click();

  // What says nothing is refused at once, with what would; Escape brings the old value back.
  const length = page.getByLabel("Length", { exact: true });
  const before = await length.inputValue();
  await length.fill("1:75");
  await length.press("Enter");
  const refused = page.locator(".row .refused").filter({ hasText: "minutes and seconds after a colon stay below 60" });
  await refused.waitFor();
  assert.equal(await length.getAttribute("aria-invalid"), "true");
  await shot("refused");
  await length.press("Escape");
  await until(() => length.getAttribute("aria-invalid"), null);
  assert.equal(await length.inputValue(), before);
  await refused.waitFor({ state: "hidden" });

  // A free length and its bounds; a value that can't be is told beside its field.
  assert.equal(await page.getByLabel("At least", { exact: true }).isVisible(), false);
  await editor.setField("Length", "free");
  await editor.setField("At most", "90%");
  await editor.setField("At least", "2s");
  await editor.setField("Search rate", "20");
  const bounded = page.getByLabel("At most", { exact: true });
  await bounded.fill("1s");
  await bounded.press("Enter");
  await page.locator(".row .refused").filter({ hasText: "the least length, 2s, is more than the most, 1s" }).waitFor();
  assert.equal(await bounded.getAttribute("aria-invalid"), "true");
  await shot("fault");
  // A field that nobody types in leaves undo to the page, without losing the focus; one that somebody does keeps it.
  await editor.answered(() => page.keyboard.press("Control+z"));
  await until(() => bounded.getAttribute("aria-invalid"), null);
  await until(() => bounded.inputValue(), "90%");
  assert.ok(await bounded.evaluate((field) => field === document.activeElement));
  await page.keyboard.type("95");
  await page.keyboard.press("Control+z");
  await page.getByRole("button", { name: "Undo set search rate" }).waitFor();
  await page.keyboard.press("Escape");
  await until(() => bounded.inputValue(), "90%");
  // Bounds go with the free length.
  await editor.setField("Length", "75%");
  assert.equal(await bounded.isVisible(), false);

  // Both are searched: a file that is imitated needs a counterpart for the second.
  await editor.answered(() => page.getByLabel("Role of second").selectOption("search"));
  await page.getByRole("button", { name: "File…", exact: true }).click();
  await page.getByRole("dialog").getByRole("button", { name: "like_first.bvh" }).click();
  await page.locator(".details .refused").filter({ hasText: "needs a counterpart for each" }).waitFor();
  await page.getByRole("button", { name: "What second is to move like: choose a file" }).click();
  await editor.answered(() => page.getByRole("dialog").getByRole("button", { name: counterpart }).click());
  await editor.setField("Reference to", "1.5");
  await page.getByText("More", { exact: true }).click();
  await editor.setField("Neighbours", "2");
  await shot("group_reference");
  assert.deepEqual(await stumbles(editor), []);

  // A file that is dropped on the references is one more of them.
  const file = `HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 9\nFrame Time: 0.033333\n${"0 0 0\n".repeat(9)}`;
  await page.evaluate((text) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([text], "dropped.bvh"));
    document
      .querySelector("section[aria-label=References]")
      .dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, file);
  await page.getByRole("group", { name: "References" }).getByRole("button", { name: "dropped", exact: true }).waitFor();
  await page.locator(".trouble:visible").waitFor();
  await editor.answered(() => page.keyboard.press("Control+z"));
  await page
    .getByRole("group", { name: "References" })
    .getByRole("button", { name: "dropped", exact: true })
    .waitFor({ state: "detached" });

  const saved = join(folder, "group.retime");
  await page.keyboard.press("Control+s");
  // The ending goes without saying.
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(join(folder, "group"));
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Saved ${saved}`).waitFor();
  // Under that name again: it is there, and is its own. Another's name is refused until one says that it may go.
  const path = page.getByRole("dialog").getByLabel("Path", { exact: true });
  await page.keyboard.press("Control+Shift+s");
  await until(() => path.inputValue(), saved);
  await path.fill("away.retime");
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByRole("alert").filter({ hasText: "This file is there already" }).waitFor();
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.keyboard.press("Control+e");
  await page.getByRole("dialog").getByLabel("What", { exact: true }).selectOption("warp");
  const warp = join(folder, "group_warp.json");
  await page.getByRole("dialog").getByLabel("Path", { exact: true }).fill(warp);
  await page.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText(`Wrote ${warp}`).waitFor({ timeout: 60_000 });
  assert.deepEqual(editor.errors, []);
  server.process.kill("SIGINT");
  await server.ended;

  // A project whose clip lies elsewhere: the page says what to type, and the clip can be looked for where it may be used.
  server = await begin("--project", project);
  const other = new Editor(await (await browser.newContext({ viewport: { width: 1280, height: 720 } })).newPage());
  await other.page.goto(server.address);
  await other.page
    .locator(".veil")
    .filter({ hasText: `type: retime edit --project ${project} --folder ${elsewhere}` })
    .waitFor();
  await other.page.screenshot({ path: join(shots, "elsewhere.png") });
  await other.page.getByRole("button", { name: "away.bvh" }).click();
  await other.page.getByRole("dialog").getByRole("button", { name: "first.bvh", exact: true }).click();
  await other.ready();
  await other.page.getByRole("button", { name: "Undo choose clip" }).waitFor();
  assert.deepEqual(other.errors, []);
  console.log(JSON.stringify({ saved, warp }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
