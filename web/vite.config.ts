import { defineConfig } from "vite";

/** Two bundles: the page (`npm run build`), and the widget of the notebook (`--mode widget`), one file each. */
export default defineConfig(({ mode }) => {
  const outDir = "../src/retime/server/page";
  if (mode === "widget") {
    return {
      publicDir: false,
      define: { "process.env.NODE_ENV": '"production"' },
      build: {
        outDir,
        emptyOutDir: false,
        target: "es2022",
        cssCodeSplit: false,
        lib: { entry: "src/widget.ts", formats: ["es"], fileName: () => "widget.js", cssFileName: "widget" },
      },
    };
  }
  return {
    base: "./",
    build: {
      outDir,
      emptyOutDir: true,
      target: "es2022",
      modulePreload: { polyfill: false },
      chunkSizeWarningLimit: 900,
    },
    test: { include: ["test/**/*.test.ts"] },
  };
});
