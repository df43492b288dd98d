// What the stage and the timeline show while something is pointed at, dragged, zoomed and played, in a real browser.
//
//     node seeing.mjs '{"python": …, "clip": …, "other": …, "mesh": …, "folder": …, "state": …, "shots": …}'
//
// Prints one JSON object: how high the map is.

import assert from "node:assert/strict";
import { join } from "node:path";
import { Editor, launch, serve, stumbles, until } from "./editor.mjs";

const { python, clip, other, mesh, folder, state, shots } = JSON.parse(process.argv[2]);
const command = [python, "-m", "retime.cli.main", "edit", clip, "--no-browser"];

/** How many pixels of two pictures differ; counted in a page that is closed then. */
async function differing(lab, one, other) {
  const count = await lab.evaluate(
    async (pictures) => {
      const [a, b] = await Promise.all(
        pictures.map(async (picture) => {
          const image = new Image();
          image.src = `data:image/png;base64,${picture}`;
          await image.decode();
          const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d");
          canvas.drawImage(image, 0, 0);
          return canvas.getImageData(0, 0, image.width, image.height).data;
        }),
      );
      let differ = 0;
      for (let i = 0; i < a.length; i += 4) {
        if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 12) differ++;
      }
      return differ;
    },
    [one, other],
  );
  await lab.close();
  return count;
}

const browser = await launch();
const server = await serve(command, folder, { XDG_STATE_HOME: state });
try {
  const editor = await Editor.open(browser, server.address);
  const { page } = editor;
  const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
  await page.getByRole("button", { name: "Got it" }).click();
  await editor.setField("Length", "65%");
  await editor.settled();

  // At 720p the map has 240 pixels, and Why folds away; opened, it stays open.
  const why = page.getByLabel("Why", { exact: true });
  const fold = why.getByRole("button", { name: /^Why, at output/ });
  assert.equal(await fold.getAttribute("aria-expanded"), "false");
  assert.equal(await why.getByText("Matched", { exact: true }).isVisible(), false);
  const box = await editor.canvas.boundingBox();
  const foot = await page.locator(".foot").boundingBox();
  assert.ok(foot.y + foot.height <= 720);
  // Where the speed's axis begins, the map has ended: a double-click there makes no lock, on it one can drag one.
  const map = await page.locator(".timeline .overlay[aria-label=Locks]").boundingBox();
  assert.ok(map.height >= 240, `the map is ${map.height} pixels high`);
  await shot("low");
  assert.deepEqual(await stumbles(editor), []);
  await fold.click();
  assert.equal(await why.getByText("Matched", { exact: true }).isVisible(), true);
  await page.reload();
  await editor.ready();
  await until(() => fold.getAttribute("aria-expanded"), "true");

  // Pointing at a frame moves both sides.
  const caption = (which) => page.locator(`.caption[data-is=${which}]`).innerText();
  await editor.scrub(0.1);
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 60, { steps: 3 });
  await page.locator(".caption[data-is=reference]").waitFor();
  for (const which of ["input", "output"])
    await until(async () => /\(under the pointer\)$/.test(await caption(which)), true);
  await shot("pointed");
  await page.mouse.move(box.x + 0.6 * box.width, box.y - 60, { steps: 3 });
  await until(async () => /pointer/.test(await caption("input")), false);

  // While a keytime is dragged both sides show its pose, wherever the playhead is.
  const key = await editor.addKey(0.45);
  await editor.scrub(0.1);
  const from = await editor.centre(key);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 4; i++) await page.mouse.move(from.x + 6 * i, from.y - 3 * i);
  for (const which of ["input", "output"]) await until(async () => /\(the keytime\)$/.test(await caption(which)), true);
  const [, shown, at] = /input ([\d.]+) s at output ([\d.]+) s/.exec(await key.getAttribute("aria-label"));
  await until(
    async () => Math.abs(Number.parseFloat((await caption("input")).replace(/^\D+/, "")) - shown) < 0.006,
    true,
  );
  await until(
    async () => Math.abs(Number.parseFloat((await caption("output")).replace(/^\D+/, "")) - at) < 0.006,
    true,
  );
  await shot("dragged");
  await page.mouse.up();
  await until(async () => /keytime/.test(await caption("input")), false);
  await editor.settled();

  // The matched pose at the playhead; onion skins as bodies.
  await page.mouse.move(box.x + 0.6 * box.width, box.y - 60);
  await editor.scrub(0.5);
  const plain = await editor.stage();
  await page.getByRole("button", { name: "Match", exact: true }).click();
  await page.locator(".caption[data-is=reference]").waitFor();
  await editor.frames(4);
  assert.notEqual(await editor.stage(), plain);
  await page.getByRole("button", { name: "Onion skins" }).click();
  await editor.frames(4);
  await shot("onion");
  await page.keyboard.press("g");
  await page.keyboard.press("o");

  // Zoomed in, the playhead stays in view: by its keys, and while it plays; the bar says what is in view.
  const bar = page.getByRole("slider", { name: "Part in view" });
  const inView = async () => {
    const [, low, high] = /output ([\d.]+) s to ([\d.]+) s/.exec(await bar.getAttribute("aria-valuetext"));
    const now = Number.parseFloat(await editor.readout("output"));
    return now >= Number(low) - 0.01 && now <= Number(high) + 0.01;
  };
  const all = await bar.getAttribute("aria-valuetext");
  for (let i = 0; i < 7; i++) await page.keyboard.press("+");
  await until(async () => (await bar.getAttribute("aria-valuetext")) === all, false);
  assert.ok(await inView());
  await page.keyboard.press("End");
  await until(inView, true);
  await shot("zoomed");
  await page.keyboard.press("Home");
  await until(inView, true);
  for (let i = 0; i < 8; i++) await page.keyboard.press("Shift+ArrowRight");
  await until(inView, true);
  await page.keyboard.press("Space");
  await page.evaluate(
    () =>
      new Promise((resolve) => {
        const readout = document.querySelector(".readout[data-is=output] input");
        const begin = Number.parseFloat(readout.value);
        const next = () => (Number.parseFloat(readout.value) > begin + 1 ? resolve() : requestAnimationFrame(next));
        next();
      }),
  );
  await page.keyboard.press("Space");
  await until(inView, true);
  // The panels follow now and then while it plays; once it stands they say where: a frame on is the next one.
  await editor.frames(3);
  const stands = await editor.frame("output");
  await page.keyboard.press("ArrowRight");
  await until(() => editor.frame("output"), stands + 1);
  // The bar moves along; its ends zoom; a double-click shows all.
  await page.keyboard.press("Home");
  await until(inView, true);
  const thumb = await editor.centre(bar);
  const before = await bar.getAttribute("aria-valuetext");
  await page.mouse.move(thumb.x, thumb.y);
  await page.mouse.down();
  await page.mouse.move(thumb.x + 60, thumb.y, { steps: 4 });
  await page.mouse.up();
  await until(async () => (await bar.getAttribute("aria-valuetext")) === before, false);
  await bar.focus();
  await page.keyboard.press("ArrowRight");
  await shot("scrolled");
  await bar.dblclick();
  await until(() => bar.getAttribute("aria-valuetext"), all);

  // A keytime that runs the clip backward: the speed below a hold is on the graph, and typed back the axis stays.
  await editor.addKey(0.7);
  await editor.settled();
  await page.getByLabel("Method", { exact: true }).selectOption({ label: "Linear" });
  await editor.settled();
  const speeds = page.getByRole("slider", { name: "Speed at keytime 1" });
  const upright = (await speeds.boundingBox()).y;
  await page.getByRole("button", { name: /^Keytime 2 of 2/ }).click();
  await editor.setField("Shows input", "2");
  await editor.settled();
  await page.locator(".trouble").waitFor({ state: "hidden" });
  const backward = (await speeds.boundingBox()).y;
  assert.ok(backward > upright + 4, "the speed of a backward piece lies below");
  await shot("backward");
  const second = page.getByRole("slider", { name: "Speed at keytime 2" });
  const axis = (await second.boundingBox()).y;
  await editor.answered(() => page.keyboard.press("Control+z"));
  await editor.settled();
  await shot("forward_again");
  assert.ok(Number.isFinite(axis));

  // A notice is at the bottom, and goes with its clip.
  await page.evaluate((path) => {
    const transfer = new DataTransfer();
    transfer.setData("text/plain", "nothing");
    document.body.dispatchEvent(
      new ClipboardEvent("paste", { clipboardData: transfer, bubbles: true, cancelable: true }),
    );
    return path;
  }, other);
  const notice = page.getByText("What was copied is no keytime");
  await notice.waitFor();
  assert.ok((await notice.boundingBox()).y > 500);
  await shot("notice");
  await page.keyboard.press("Control+o");
  await page.getByRole("dialog").getByRole("button", { name: other }).click();
  await notice.waitFor({ state: "detached" });
  await editor.ready();

  // A figure has its own mesh where the file has one, and is its bare joints where that is not wanted.
  const switched = page.getByRole("button", { name: "Mesh", exact: true });
  assert.equal(await switched.isVisible(), false);
  await page.keyboard.press("Control+o");
  await page.getByRole("dialog").getByRole("button", { name: mesh }).click();
  await switched.waitFor();
  await editor.ready();
  await editor.settled();
  await editor.dismiss();
  await editor.scrub(0.5);
  await page.mouse.move(box.x + 0.6 * box.width, box.y - 200);
  await editor.frames(4);
  const dressed = await editor.stage();
  await shot("mesh");
  await switched.click();
  await page.mouse.move(box.x + 0.6 * box.width, box.y - 200);
  await editor.frames(4);
  const bare = await editor.stage();
  assert.notEqual(bare, dressed);
  await shot("joints_alone");
  // Onion skins and the matched pose are what the figure is: the mesh's cover far more of the stage than the joints'.
  const covered = async (plain) => {
    await page.mouse.move(box.x + 0.6 * box.width, box.y - 200);
    await editor.frames(4);
    return differing(await page.context().newPage(), plain, await editor.stage());
  };
  const around = {};
  // Joints would be hidden in the mesh: of the one pose that is matched it is enough that the mesh covers more.
  for (const [key, button, times] of [
    ["onion", "Onion skins", 1.5],
    ["match", "Match", 1],
  ]) {
    await page.getByRole("button", { name: button, exact: true }).click();
    if (key === "match") await page.locator(".caption[data-is=reference]").waitFor();
    const joints = await covered(bare);
    await switched.click();
    const body = await covered(dressed);
    await shot(`mesh_${key}`);
    around[key] = { joints, body };
    assert.ok(joints > 100 && body > times * joints, `${key}: ${body} pixels of the mesh, ${joints} of the joints`);
    await page.getByRole("button", { name: button, exact: true }).click();
    await switched.click();
  }

  assert.deepEqual(editor.errors, []);
  console.log(JSON.stringify({ map: map.height, around }));
} finally {
  await browser.close();
  server.process.kill("SIGKILL");
}
