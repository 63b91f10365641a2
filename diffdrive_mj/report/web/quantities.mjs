// Numbers with their units, as diffdrive_mj/_text.py prints them.

const PREFIXES = [[1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n'], [1e-12, 'p']];

// A number with the prefix of its unit that reads best, such as 0.0123 m as 12.3 mm.
export function quantity(value, unit, digits = 3) {
  const size = Math.abs(value), enough = 1 - 0.5 * 10 ** -digits;
  const [scale, prefix] = size === 0 ? [1, ''] : PREFIXES.find(([one]) => size >= one * enough) ?? PREFIXES.at(-1);
  return `${(value / scale).toPrecision(digits)} ${prefix}${unit}`;
}

// An angle in degrees; of one that is no longer worth its digits, that it is small.
export function degrees(radians) {
  const angle = radians * 180 / Math.PI, size = Math.abs(angle);
  if (size === 0) return '0°';
  return size < 0.01 ? 'below 0.01°' : `${angle < 0 ? '−' : ''}${size < 9.995 ? size.toFixed(2) : size.toFixed(1)}°`;
}

// A time in seconds, with two digits after the point.
export const seconds = t => `${t.toFixed(2)} s`;
