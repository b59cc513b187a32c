// Parts of the panel. Everything is a native control, so that keys and screen readers work.

/** An element with properties and children. */
export function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children.filter((child) => child != null && child !== false));
  return element;
}

export function fieldset(title, ...children) {
  return make('fieldset', {}, title ? make('legend', { textContent: title }) : null, ...children);
}

export function slider(label, { min, max, step, value }, on) {
  const input = make('input', { type: 'range', min, max, step, value });
  // the value goes in after its range, which would clip it
  input.value = value;
  input.addEventListener('input', () => on(input.valueAsNumber));
  return Object.assign(make('label', {}, make('span', { textContent: label }), input), { input });
}

/** A list of [value, text]. */
export function select(label, options, value, on) {
  const list = make('select', {}, ...options.map(([of, text]) => make('option', { value: of, textContent: text })));
  list.value = value;
  list.addEventListener('change', () => on(list.value));
  return Object.assign(make('label', {}, make('span', { textContent: label }), list), { list });
}

export function check(label, checked, on, color) {
  const input = make('input', { type: 'checkbox', checked });
  input.addEventListener('change', () => on(input.checked));
  const swatch = color ? make('i') : null;
  if (swatch) swatch.style.background = color;
  return Object.assign(make('label', { className: 'check' }, input, swatch, make('span', { textContent: label })), { input });
}

export function button(text, on) {
  const made = make('button', { type: 'button', textContent: text });
  made.addEventListener('click', on);
  return made;
}

export function row(...children) {
  return make('div', { className: 'row' }, ...children);
}

/** A text that changes. */
export function output() {
  return make('output');
}
