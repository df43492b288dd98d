/** The icons, drawn on a grid of 16 by strokes in the colour of the text beside them. */

const PATHS = {
  play: "M5 3.2v9.6l7.6-4.8z",
  pause: "M5.2 3.2v9.6M10.8 3.2v9.6",
  back: "M11 3.2v9.6L3.4 8z",
  first: "M4 3.2v9.6M12.2 3.6L6.2 8l6 4.4z",
  last: "M12 3.2v9.6M3.8 3.6L9.8 8l-6 4.4z",
  previous: "M10 3.6L5.4 8l4.6 4.4",
  next: "M6 3.6L10.6 8 6 12.4",
  loop: "M3 7.2V6.4A2.6 2.6 0 0 1 5.6 3.8H13M11 1.8l2 2-2 2M13 8.8v.8a2.6 2.6 0 0 1-2.6 2.6H3M5 14.2l-2-2 2-2",
  link: "M6.6 9.4l2.8-2.8M7.2 4.9l1.4-1.4a2.76 2.76 0 0 1 3.9 3.9l-1.4 1.4M8.8 11.1l-1.4 1.4a2.76 2.76 0 0 1-3.9-3.9l1.4-1.4",
  snap: "M4 2.5v5.6a4 4 0 0 0 8 0V2.5M2.6 5.4h2.8M10.6 5.4h2.8",
  undo: "M6 3L3 6l3 3M3.2 6H10a3.4 3.4 0 0 1 0 6.8H6.4",
  redo: "M10 3l3 3-3 3M12.8 6H6a3.4 3.4 0 0 0 0 6.8h3.6",
  open: "M2.2 12.6V3.8h4l1.4 1.8h6.2v7z",
  save: "M3 3h8l2 2v8H3zM5.4 3v3.4h4.4V3M5 13V9.4h6V13",
  export: "M8 10V2.4M5 5.2l3-3 3 3M3 9.4v4h10v-4",
  sun: "M8 5.4a2.6 2.6 0 1 0 0 5.2 2.6 2.6 0 0 0 0-5.2M8 1.6v1.6M8 12.8v1.6M1.6 8h1.6M12.8 8h1.6M3.5 3.5l1.1 1.1M11.4 11.4l1.1 1.1M12.5 3.5l-1.1 1.1M4.6 11.4l-1.1 1.1",
  moon: "M13 9.6A5.6 5.6 0 0 1 6.4 3a5.4 5.4 0 1 0 6.6 6.6z",
  help: "M6 6.2a2 2 0 1 1 2.9 1.8c-.6.3-.9.8-.9 1.5M8 11.9v.2",
  key: "M8 2.8L13.2 8 8 13.2 2.8 8z",
  lock: "M4 7.4h8v5.4H4zM5.6 7.4V5.2a2.4 2.4 0 0 1 4.8 0v2.2",
  trash: "M3.4 4.6h9.2M6.4 4.4V3h3.2v1.4M4.6 4.8l.5 8.2h5.8l.5-8.2",
  plus: "M8 3.4v9.2M3.4 8h9.2",
  close: "M4 4l8 8M12 4l-8 8",
  fit: "M2.8 8h10.4M5 5.6L2.6 8 5 10.4M11 5.6L13.4 8 11 10.4",
  folder: "M2.2 12.6V3.8h4l1.4 1.8h6.2v7z",
  file: "M4 2.4h5l3 3v8.2H4zM9 2.6v3h3",
  up: "M8 12.6V3.8M4.4 7.2L8 3.6l3.6 3.6",
  compare: "M8 2.4v11.2M3 5h3v6H3zM10 5h3v6h-3z",
} as const;

export type IconName = keyof typeof PATHS;

const NAMESPACE = "http://www.w3.org/2000/svg";
const FILLED = new Set<IconName>(["play", "back", "first", "last"]);

export function icon(name: IconName): SVGSVGElement {
  const svg = document.createElementNS(NAMESPACE, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("class", FILLED.has(name) ? "icon filled" : "icon");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(NAMESPACE, "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  return svg;
}
