% The functions for Octave against the program, to the last bit but one, which Octave's jsondecode may miss; and what they
% refuse.
%   octave-cli --path FUNCTIONS test_functions.m PROGRAM SCRATCH
1;

function equal (found, expected)
  assert (found, expected, -2 * eps);
end

function text = program (of, varargin)
  [code, text] = system (strjoin ([{of}, varargin], ' '));
  assert (code, 0);
end

function same (found, expected)
  expected = expected.recordings;
  if iscell (expected), expected = expected{1}; end
  expected = expected(1);
  assert (found.trust, expected.trust);
  for p = 1:numel (expected.parameters)
    of = expected.parameters(p);
    if iscell (of), of = of{1}; end
    mine = found.parameters(p);
    assert (mine.name, of.name);
    assert (mine.unit, of.unit);
    equal ([mine.value, mine.sd, mine.interval50, mine.interval90], [of.value, of.sd, of.interval50', of.interval90']);
    if isempty (of.normalized)
      assert (isnan (mine.normalized));
    else
      equal ([mine.normalized, mine.normalized_interval90], [of.normalized, of.normalized_interval90']);
    end
  end
  equal ([found.rms_residual_deg, found.variance_accounted_for, found.peak_to_peak_deg, found.response_ratio],
         [expected.fit.rms_residual_deg, expected.fit.variance_accounted_for, expected.peak_to_peak_deg, expected.response_ratio]);
  assert (strjoin ({found.warnings.code}), codes_of (expected.warnings));
end

function codes = codes_of (warnings)
  codes = '';
  if ! isempty (warnings), codes = strjoin ({warnings.code}); end
end

function refused (code, call)
  found = '';
  try
    call ();
  catch failure
    found = failure.identifier;
  end
  assert (found, ['decid:', code]);
end

function write (file, varargin)
  to = fopen (file, 'w');
  fputs (to, [strjoin(varargin, "\n"), "\n"]);
  fclose (to);
end

% The program's options of the same meaning.
function text = options_of (pairs)
  text = '';
  for i = 1:2:numel (pairs)
    [name, value] = pairs{i:i + 1};
    if any (strcmp (name, {'trial', 'invert_tilt'})), continue, end
    if strcmp (name, 'trial_column'), name = 'trial'; end
    if strcmp (name, 'invert_sway'), name = 'invert'; value = 'both'; end
    text = [text, ' --', strrep(name, '_', '-'), ' ', num2str(value)];
  end
end

arguments = argv ();
decid = arguments{end - 1};
folder = arguments{end};
file = fullfile (folder, 'trial.csv');
program (decid, 'simulate --seed 7 --quiet -o', file);

table = dlmread (file, ',', 1, 0);

% Every option of a file.
names = 'time,sway,tilt_rad,leg,trunk,hip,shoulder,ankle,gappy,offset,minus_deg,platform';
values = [table(:, 1), table(:, 2:3) * pi / 180, table(:, 2) * [0.9, 1.2, 1.6, 2.4, 0.1, 1, 1, -1], -table(:, 3) * pi / 180];
values(308, 9) = -77.5;
values(:, 10) += 25;
form = ['%.2f', repmat(',%.9f', 1, 11), "\n"];
lines = strsplit (strtrim (sprintf (form, values')), "\n");
rows = arrayfun (@(k) sprintf ('%.2f,%d', k / 100, mod (k, 7)), 1:60, 'UniformOutput', false);
in_folder = @(name) fullfile (folder, [name, '.csv']);
write (in_folder ('table'), names, lines{:});
write (in_folder ('numbers'), lines{:});
write (in_folder ('sections'), 'Devices', 'time,sway_deg', rows{:}, '', 'Trajectories', names, lines{:});
write (in_folder ('trials'), ['subject,', names], strcat ('s1,', lines){:}, strcat ('s2,', lines(1:6001)){:});
write (in_folder ('blocks'), ['block,', names], strcat ('1,', lines(1:6000)){:}, strcat ('2,', lines(6001:end)){:});
models = fullfile (fileparts (mfilename ('fullpath')), '..', '..', '..', 'models');
cases = {'table', {'column', 'sway', 'unit', 'rad', 'tilt_column', 'tilt_rad', 'model', fullfile(models, 'dec2015.safetensors')}, ...
         'table', {'column', 'offset', 'unit', 'deg', 'detrend', 'offset'}, ...
         'table', {'column', 'gappy', 'fill_gaps', 0.1, 'missing', -77.5, 'tilt_column', 'none', 'begin', 0.5}, ...
         'table', {'column', 'minus_deg', 'tilt_column', 'platform', 'tilt_unit', 'rad', 'invert_sway', true, 'invert_tilt', true}, ...
         'table', {'column', 'hip', 'unit', 'cm', 'com_height', 0.9, 'mass', 154, 'height', 1.75}, ...
         'table', {'leg', 'leg', 'trunk', 'trunk', 'detrend', 'linear'}, ...
         'table', {'hip', 'hip', 'shoulder', 'shoulder', 'ankle', 'ankle', 'unit', 'cm', 'mass', 70, 'height', 1.75}, ...
         'numbers', {'column', '2', 'skip_lines', 5, 'rate', 99.5, 'unit', 'rad', 'tilt_column', '3', 'tilt_unit', 'rad'}, ...
         'sections', {'section', '2', 'column', 'offset', 'detrend', 'offset'}, ...
         'trials', {'trial_column', 'subject', 'trial', 's1', 'column', 'sway', 'unit', 'rad'}, ...
         'blocks', {'trial_column', 'none', 'column', 'sway', 'unit', 'rad'}};
for c = 1:2:numel (cases)
  found = decid_identify (in_folder (cases{c}), cases{c + 1}{:});
  [~, text] = system (strjoin ({decid, 'identify --quiet --json', in_folder(cases{c}), options_of(cases{c + 1})}, ' '));
  same (found, jsondecode (text));
end
assert (decid_trial_names (in_folder ('trials'), 'subject', 'skip_lines', 0), {'s1', 's2'});

% Samples, as a column and as a row.
found = decid_identify (file);
assert (numel (found.sway), 12100);
for sway = {table(:, 2), table(:, 2)'}
  again = decid_identify (sway{1}, 'rate', 100, 'unit', 'deg');
  assert ([again.parameters.value], [found.parameters.value]);
end

% Samples with the platform's tilt, which begins 2.5 s late.
sway = [zeros(250, 1); table(:, 2)];
tilt = [zeros(250, 1); table(:, 3)];
log_file = fullfile (folder, 'log.csv');
lines = arrayfun (@(k) sprintf ('%.2f,%.17g,%.17g', k / 100, sway(k), tilt(k)), 1:numel (sway), 'UniformOutput', false);
write (log_file, 'time,sway_deg,platform_deg', lines{:});
found = decid_identify (log_file, 'tilt_column', 'platform_deg');
assert (found.tilt_delay_s, 2.5, 0.001);
again = decid_identify (-sway, 'rate', 100, 'unit', 'deg', 'tilt', -tilt' * pi / 180, 'tilt_unit', 'rad', 'invert_sway', true, ...
                        'invert_tilt', true);
equal ([again.parameters.value], [found.parameters.value]);
assert ([again.tilt_delay_s, again.tilt_correlation, again.tilt_gain], ...
        [found.tilt_delay_s, found.tilt_correlation, found.tilt_gain], 1e-9);
samples = {'rate', 100, 'unit', 'deg'};
refused ('size_mismatch', @() decid_identify (sway, samples{:}, 'tilt', tilt(2:end)));
refused ('setting_malformed', @() decid_identify (sway, samples{:}, 'tilt', 'tilt_deg'));
refused ('setting_malformed', @() decid_identify (sparse (sway), samples{:}));
refused ('setting_conflict', @() decid_identify (sway, samples{:}, 'fill_gaps', 0.1));
refused ('setting_conflict', @() decid_identify (log_file, 'tilt', tilt));

% Simulation and reading.
trial = decid_simulate ('seed', 7);
assert (round (rad2deg (trial.sway) * 1e8), round (table(:, 2) * 1e8), 1);
other = decid_simulate ('seed', 7, 'Kp', 700, 'protocol', 'short');
assert (numel (other.sway), 6370);
assert (other.Kp, 700);
program (decid, 'simulate --seed 7 --controller ic --weight 0.5 --protocol short --quiet -o', fullfile (folder, 'ic.csv'));
other = decid_simulate ('seed', 7, 'controller', 'ic', 'W', 0.5, 'protocol', 'short');
assert (round (rad2deg (other.sway) * 1e8), round (dlmread (fullfile (folder, 'ic.csv'), ',', 1, 1)(:, 1) * 1e8), 1);
assert (other.W, 0.5);
recording = decid_read (file, 'tilt_column', 'tilt_deg');
assert (recording.sway, table(:, 2) * (pi / 180));
assert (numel (recording.tilt), 12100);
assert (recording.column, 'com_sway_deg');

refused ('unit_unknown', @() decid_identify (sway, 'rate', 100, 'unit', 'mm'));
refused ('setting_out_of_range', @() decid_read (file, 'skip_lines', -1));
refused ('setting_out_of_range', @() decid_trial_names (file, 'subject', 'skip_lines', -1));

% A fit of a trial of 4 s.
golden = fullfile (fileparts (mfilename ('fullpath')), '..', '..', 'golden', '0.2.0');
network = fullfile (golden, 'net.safetensors');
brief = fullfile (folder, 'brief.csv');
program (decid, 'simulate --seed 7 --quiet --protocol', fullfile (golden, 'protocol.json'), '-o', brief);
asked = {'model', network, 'protocol', fullfile(golden, 'protocol.json'), 'max_draws', 8, 'seed', 3, 'prior_start', 0.05, ...
         'prior_gain', 0.1, 'prior_noise', 0.05, 'mass', 70, 'height', 1.75, 'begin', 0.02, 'detrend', 'offset'};
fitted = decid_fit (brief, asked{:}, 'ranges', struct ('Kp', [300 2000], 'delay', [0.05 0.2]), 'priors', ...
                    struct ('delay', [0.12 0.02], 'Kp/mgh', [1.0 0.2]), 'moved_before', true);
expected = jsondecode (program (decid, ['fit --json --quiet --range Kp=300,2000 --range delay=0.05,0.2 --prior delay=0.12,0.02 ' ...
                                        '--prior Kp/mgh=1.0,0.2 --moved-before'], options_of (asked), brief));
same (fitted, expected);
assert ({fitted.quantities.name}, {'sensor_noise_deg', 'start_s', 'gain'});
equal (fitted.quantities(3).value, expected.recordings.gain.value);
assert (numel (fitted.draws.Kp), expected.recordings.diagnostics.draws);

% Several controllers of it.
asked = {'model', network, 'max_draws', 8};
fitted = decid_fit (brief, asked{:}, 'controllers', 'ic,dec');
expected = jsondecode (program (decid, 'fit --json --quiet --controller ic,dec', options_of (asked), brief));
same (fitted, expected);
assert (numel (fitted.comparison), 2);
for c = 1:2
  of = expected.recordings.controllers{c};
  mine = fitted.comparison(c);
  assert (mine.controller, of.controller);
  assert (mine.comparable, of.comparable);
  equal ([mine.log_predictive_density, mine.difference, mine.difference_standard_error, mine.weight],
         [of.log_predictive_density, of.difference, of.difference_standard_error, of.weight]);
end
assert (isempty (decid_fit (brief, asked{:}).comparison));
refused ('setting_unknown', @() decid_fit (brief, asked{:}, 'controllers', 'dec,pid'));
refused ('setting_conflict', @() decid_fit (brief, asked{:}, 'controllers', 'dec,ic,dec'));

% A study of four persons in two sessions.
lines = {'participant_id,group,session,file,age'};
for person = 1:4
  for session = 1:2
    name = sprintf ('p%d_%d.csv', person, session);
    program (decid, sprintf ('simulate --seed %d --quiet -o', 10 * person + session), fullfile (folder, name));
    lines{end + 1} = sprintf ('p%d,%s,%d,%s,%d', person, 'ab'(1 + mod (person, 2)), session, name, 60 + person);
  end
end
sheet = fullfile (folder, 'people.csv');
write (sheet, lines{:});
study = decid_study (sheet, 'group', true, 'within', 'session', 'covariates', 'age');
expected = jsondecode (program (decid, ['identify --json --within session --covariates age --group ', sheet, ' --study'], sheet));
assert (iscell (study.recordings));
assert (numel (study.recordings), 8);
assert (isequaln (study.hierarchical, expected.hierarchical));
assert (isequaln (study.recordings{8}.parameters, expected.recordings(end).parameters));
refused ('setting_unknown', @() decid_study (sheet, 'people', true));
refused ('setting_conflict', @() decid_study (sheet, 'controllers', 'dec,ic'));  % not fits
refused ('setting_malformed', @() decid_study (7));

refused ('file_missing', @() decid_identify ('no.csv'));
refused ('setting_unknown', @() decid_trial_names (file, 'subject', 'rate', 100));
refused ('setting_malformed', @() decid_trial_names (7, 'subject'));
refused ('setting_missing', @() decid_identify (table(:, 2)));
refused ('setting_malformed', @() decid_identify (single (table(:, 2)), 'rate', 100, 'unit', 'deg'));
refused ('setting_unknown', @() decid_identify (file, 'weight', 70));
refused ('setting_unknown', @() decid_simulate ('kp', 700));
refused ('setting_malformed', @() decid_identify (file, 'mass', 'heavy', 'height', 1.75));
refused ('setting_unknown', @() decid_identify (file, 'unit', 'grad'));
refused ('setting_malformed', @() decid_simulate ('seed', 1.5));
refused ('setting_out_of_range', @() decid_simulate ('seed', -1));
refused ('setting_malformed', @() decid_fit (file, 'ranges', struct ('delay', sparse ([0, 0.2]))));
try
  decid_identify (file, 'tilt_column', 'none', 'begin', 500);
  message = '';
catch failure
  message = failure.message;
end
assert (! isempty (strfind (message, ' begin ')));  % Octave's name, and not C's field
same (decid_identify (file), jsondecode (program (decid, 'identify --json', file)));  % none of these did harm
disp ('octave: all the same');
