/** The editor as a widget in a notebook: the same messages, over the widget's own channel. */

import "./style.css";
import { App } from "./app";

/** What anywidget gives a widget: its model, and the element to draw on. */
interface Model {
  send(content: unknown, callbacks?: unknown, buffers?: ArrayBuffer[]): void;
  on(name: "msg:custom", handler: (content: unknown, buffers: DataView[]) => void): void;
  off(name: "msg:custom", handler: (content: unknown, buffers: DataView[]) => void): void;
  get(name: string): unknown;
}

function render({ model, el }: { model: Model; el: HTMLElement }): () => void {
  const root = document.createElement("div");
  const height = Number(model.get("height"));
  root.style.height = `${height > 0 ? height : 720}px`;
  el.append(root);
  const app = new App(root, { shortcutsFrom: "element" });
  const heard = (content: unknown, buffers: DataView[]): void => {
    const [view] = buffers;
    if (view) {
      // Arrays are views of the frame, so it has to begin at a multiple of 8 bytes: a copy does.
      const frame = view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength);
      app.connection.bytes(frame as ArrayBuffer);
    } else app.connection.text(JSON.stringify(content));
  };
  model.on("msg:custom", heard);
  app.connection.opened({ send: (text) => model.send(JSON.parse(text)) });
  return () => {
    model.off("msg:custom", heard);
    app.close();
  };
}

export default { render };
