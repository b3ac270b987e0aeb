// Style sheets are imported for their effect: esbuild gathers them into studio.css.

declare module "*.css";
