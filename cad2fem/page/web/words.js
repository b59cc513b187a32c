// What keys of reports are called.

const KEYS = {
  load: 'load', t: 'time', residual: 'unbalanced force', residual_wanted: 'unbalanced force that is allowed',
  rounding_floor: 'unbalanced force of rounding', newton_iterations: 'Newton iterations', volume_rest: 'volume at rest',
  out_of_balance: 'sum of all forces', gradient_norm: 'norm of the gradient', motion_m: 'largest motion of a vertex [m]', time_s: 'time [s]',
};

const words = (key) => KEYS[key] ?? key.replaceAll('_', ' ');

/** What stands before the keys of a group, by its own. */
const GROUPS = {
  probes: (name) => name,
  chambers: (chamber, key) => `${words(key)} of ${chamber}`,
  mean_displacement: (tag) => `mean displacement of ${tag}`,
  reactions: (tag) => `reaction at ${tag}`,
  rigid: (part, key) => `${words(key)} of ${part}`,
  energies: (term) => `energy: ${words(term)}`,
  force_balance: (load) => (load === 'out_of_balance' ? words(load) : `force: ${words(load)}`),
  collisions: (key) => `contact: ${words(key)}`,
};

/** The words for a number of a report by its keys. */
export function inWords(keys) {
  const [group, ...rest] = keys;
  return rest.length > 0 && GROUPS[group] ? GROUPS[group](...rest) : keys.map(words).join(', ');
}
