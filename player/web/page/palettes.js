// Palettes of the joint's layers, as player/scene/joint_layers. Stops in sRGB, evenly spaced.
import { Color, SRGBColorSpace } from "three";

const stops = (text) => text.split(" ").map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
/// "plasma" of matplotlib (Smith and van der Walt, CC0), reversed.
export const gapPalette = stops("F0F921 FCCE25 FCA636 F2844B E16462 CC4778 B12A90 8F0DA4 6A00A8 41049D 0D0887");
/// Moreland (2009), Diverging color maps for scientific visualization.
export const strainPalette = stops("3B4CC0 5977E3 7B9FF9 9EBEFF C0D4F5 DDDCDC F2CBB7 F7AC8E EE8468 D65244 B40426");

export const interpolated = (a, b, part) => a.map((x, k) => x + part * (b[k] - x));

/// sRGB colour at `position` on [0, 1], clamped.
export function colourAt(palette, position) {
  const at = Math.min(Math.max(position, 0), 1) * (palette.length - 1), k = Math.min(Math.floor(at), palette.length - 2);
  return interpolated(palette[k], palette[k + 1], at - k);
}

const colour = new Color();
/// Writes an sRGB colour to an array of linear colours for the shader.
export function setLinear(array, at, rgb) {
  colour.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, SRGBColorSpace);
  colour.toArray(array, at);
}

/// Converts linear RGB to sRGB.
export function srgbFromLinear(linear) {
  return new Color(...linear).getRGB(new Color(), SRGBColorSpace).toArray().map((x) => 255 * x);
}

export const gradientOf = (palette) => `linear-gradient(to right, ${palette.map((rgb) => `rgb(${rgb})`).join(", ")})`;
