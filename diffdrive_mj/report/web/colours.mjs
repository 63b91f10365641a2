// What is drawn in which colour: those of the page's style sheet, and a scale for errors.

// Matplotlib's plasma, at even steps: of even perceived steps, and told apart by colour-blind readers.
const PLASMA = [[13, 8, 135], [84, 2, 163], [139, 10, 165], [185, 50, 137], [219, 92, 104], [244, 136, 73], [254, 188, 43], [240, 249, 33]];

// The colour of a share between 0 and 1 of the largest error; on a dark page the scale leaves out its dark end, on a
// light one its light end.
export function errorColour(share, dark) {
  const bounded = Math.min(Math.max(share || 0, 0), 1);
  const at = (dark ? 0.36 + 0.64 * bounded : 0.74 * bounded) * (PLASMA.length - 1);
  const k = Math.min(Math.floor(at), PLASMA.length - 2), part = at - k;
  const mixed = PLASMA[k].map((low, i) => Math.round(low + (PLASMA[k + 1][i] - low) * part));
  return `rgb(${mixed.join(' ')})`;
}

// The style sheet's colours for canvases, which may change with the theme.
export function palette(element) {
  const style = getComputedStyle(element), read = name => style.getPropertyValue(`--${name}`).trim();
  const names = ['ink', 'muted', 'line', 'floor', 'truth', 'ghost', 'haze'];
  const found = Object.fromEntries(names.map(name => [name, read(name)]));
  return {...found, font: `12px ${style.fontFamily}`, dark: matchMedia('(prefers-color-scheme: dark)').matches};
}
