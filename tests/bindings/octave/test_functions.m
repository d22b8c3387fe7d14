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

arguments = argv ();
decid = arguments{end - 1};
folder = arguments{end};
file = fullfile (folder, 'trial.csv');
program (decid, 'simulate --seed 7 --quiet -o', file);

% A file, its options, and a body.
found = decid_identify (file);
same (found, jsondecode (program (decid, 'identify --json', file)));
assert (numel (found.sway), 12100);
same (decid_identify (file, 'mass', 70, 'height', 1.75, 'detrend', 'offset', 'column', 'com_sway_deg'),
      jsondecode (program (decid, 'identify --json --mass 70 --height 1.75 --detrend offset --column com_sway_deg', file)));

% Samples, as a column and as a row.
table = dlmread (file, ',', 1, 0);
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
assert (isnan (decid_identify (file, 'tilt_column', 'none').tilt_delay_s));
for again = {decid_identify(sway, 'rate', 100, 'unit', 'deg', 'tilt', tilt), ...
             decid_identify(-sway, 'rate', 100, 'unit', 'deg', 'tilt', -tilt', 'tilt_unit', 'deg', 'invert_sway', true, ...
                            'invert_tilt', true)}
  assert ([again{1}.parameters.value], [found.parameters.value]);
  assert ([again{1}.tilt_delay_s, again{1}.tilt_correlation, again{1}.tilt_gain], ...
          [found.tilt_delay_s, found.tilt_correlation, found.tilt_gain]);
end
again = decid_identify (sway, 'rate', 100, 'unit', 'deg', 'tilt', 1.25 * tilt * pi / 180, 'tilt_unit', 'rad');
assert (again.tilt_gain, 1.25 * found.tilt_gain, 1e-9);
assert (any (strcmp ({again.warnings.code}, 'tilt_of_other_size')));
samples = {'rate', 100, 'unit', 'deg'};
refused ('protocol_mismatch', @() decid_identify (sway, samples{:}, 'tilt', -tilt));
refused ('size_mismatch', @() decid_identify (sway, samples{:}, 'tilt', tilt(2:end)));
refused ('setting_malformed', @() decid_identify (sway, samples{:}, 'tilt', 'tilt_deg'));
refused ('setting_malformed', @() decid_identify (sparse (sway), samples{:}));
refused ('setting_missing', @() decid_identify (sway, samples{:}, 'invert_tilt', true));
refused ('setting_conflict', @() decid_identify (sway, samples{:}, 'tilt', tilt, 'begin', 1));
refused ('setting_conflict', @() decid_identify (sway, samples{:}, 'fill_gaps', 0.1));
refused ('setting_conflict', @() decid_identify (log_file, 'tilt', tilt));
refused ('value_invalid', @() decid_fit (sway, samples{:}, 'tilt', [NaN; tilt(2:end)]));
found = decid_identify (file);

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

% Tables and recordings of one file.
rows = arrayfun (@(k) sprintf ('%.2f,%.6f', k / 100, sin (k / 10)), 1:60, 'UniformOutput', false);
sections = fullfile (folder, 'sections.csv');
write (sections, 'Devices', 'time,sway_deg', rows{:}, '', 'Trajectories', 'time,sway_rad', rows{:});
assert (decid_read (sections, 'section', 'Trajectories').column, 'sway_rad');
assert (decid_read (sections, 'section', '1').column, 'sway_deg');
gap = fullfile (folder, 'gap.csv');
write (gap, 'made by hand', 'time,sway_deg', rows{1:30}, '0.31,-77.5', rows{32:60});
assert (decid_read (gap, 'missing', -77.5, 'fill_gaps', 0.1).sway(31), sin (3.1) * pi / 180, 1e-4);
assert (decid_read (gap, 'skip_lines', 1).sway(31), -77.5 * pi / 180, 1e-6);
refused ('setting_out_of_range', @() decid_read (gap, 'skip_lines', -1));
refused ('value_missing', @() decid_read (gap, 'missing', -77.5));
lines = strsplit (strtrim (fileread (file)), "\n");
several = [strcat('s1,', lines(2:end)), strcat('s2,', lines(2:6001))];
long = fullfile (folder, 'long.csv');
write (long, ['subject,', lines{1}], several{:});
assert (decid_trial_names (long, 'subject'), {'s1', 's2'});
assert (numel (decid_read (long, 'trial_column', 'subject', 'trial', 's2').sway), 6000);
same (decid_identify (long, 'trial_column', 'subject', 'trial', 's1'), jsondecode (program (decid, 'identify --json', file)));
blocks = fullfile (folder, 'blocks.csv');
write (blocks, 'block,time,sway_deg', strcat ('1,', rows(1:30)){:}, strcat ('2,', rows(31:60)){:});
assert (numel (decid_read (blocks, 'trial_column', 'none').sway), 60);

% Markers, positions and segments; an offset of the sensor.
markers = fullfile (folder, 'markers.csv');
lines = arrayfun (@(k) sprintf ('%.2f,%.9f,%.9f,%.9f,%.9f', (k - 1) / 100, table(k, 2) * [1.6, 2.4, 1, 1] + [0, 0, 25, 0]), ...
                  1:size (table, 1), 'UniformOutput', false);
write (markers, 'time,hip_cm,shoulder_cm,sensor_deg,leg_deg', lines{:});
same (decid_identify (markers, 'hip', 'hip_cm', 'shoulder', 'shoulder_cm', 'mass', 70, 'height', 1.75),
      jsondecode (program (decid, 'identify --json --hip hip_cm --shoulder shoulder_cm --mass 70 --height 1.75', markers)));
same (decid_identify (markers, 'column', 'sensor_deg', 'detrend', 'offset'),
      jsondecode (program (decid, 'identify --json --column sensor_deg --detrend offset', markers)));
assert (numel (decid_read (markers, 'hip', 'hip_cm', 'shoulder', 'shoulder_cm', 'height', 1.75).sway), 12100);
assert (numel (decid_read (markers, 'column', 'hip_cm', 'unit', 'cm', 'com_height', 0.9).sway), 12100);
assert (numel (decid_read (markers, 'leg', 'leg_deg', 'trunk', 'sensor_deg').sway), 12100);
refused ('unit_unknown', @() decid_identify (sway, 'rate', 100, 'unit', 'mm'));

% A fit of a trial of 4 s.
golden = fullfile (fileparts (mfilename ('fullpath')), '..', '..', 'golden', '0.2.0');
network = fullfile (golden, 'net.safetensors');
brief = fullfile (folder, 'brief.csv');
program (decid, 'simulate --seed 7 --quiet --protocol', fullfile (golden, 'protocol.json'), '-o', brief);
fitted = decid_fit (brief, 'model', network, 'max_draws', 8, 'ranges', struct ('Kp', [300 2000], 'delay', [0.05 0.2]), ...
                    'priors', struct ('delay', [0.12 0.02]), 'moved_before', true);
expected = jsondecode (program (decid, ['fit --max-draws 8 --json --quiet --range Kp=300,2000 --range delay=0.05,0.2 ' ...
                                        '--prior delay=0.12,0.02 --moved-before --model'], network, brief));
same (fitted, expected);
assert ({fitted.quantities.name}, {'sensor_noise_deg', 'start_s', 'gain'});
equal (fitted.quantities(3).value, expected.recordings.gain.value);
assert (numel (fitted.draws.Kp), expected.recordings.diagnostics.draws);

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
refused ('file_missing', @() decid_study ('no.csv'));
refused ('setting_unknown', @() decid_study (sheet, 'within', 'age'));
refused ('setting_unknown', @() decid_study (sheet, 'people', true));
refused ('setting_malformed', @() decid_study (7));

refused ('file_missing', @() decid_identify ('no.csv'));
refused ('file_missing', @() decid_identify (file, 'model', 'no.safetensors'));
refused ('recording_ambiguous', @() decid_read (long, 'trial_column', 'subject'));
refused ('setting_missing', @() decid_read (long, 'trial', 's1'));
refused ('column_missing', @() decid_trial_names (long, 'person'));
refused ('setting_unknown', @() decid_read (sections, 'section', 'Markers'));
refused ('setting_unknown', @() decid_trial_names (long, 'subject', 'rate', 100));
refused ('setting_malformed', @() decid_trial_names (7, 'subject'));
refused ('setting_missing', @() decid_identify (table(:, 2)));
refused ('setting_malformed', @() decid_identify (single (table(:, 2)), 'rate', 100, 'unit', 'deg'));
refused ('setting_unknown', @() decid_identify (file, 'weight', 70));
refused ('setting_unknown', @() decid_simulate ('kp', 700));
refused ('setting_unknown', @() decid_simulate ('controller', 'pid'));
refused ('setting_unknown', @() decid_simulate ('controller', 'ic', 'theta', 0));
refused ('setting_malformed', @() decid_identify (file, 'mass', 'heavy', 'height', 1.75));
refused ('setting_unknown', @() decid_identify (file, 'unit', 'grad'));
refused ('setting_malformed', @() decid_simulate ('seed', 1.5));
refused ('setting_out_of_range', @() decid_simulate ('seed', -1));
refused ('setting_malformed', @() decid_fit (file, 'ranges', struct ('delay', sparse ([0, 0.2]))));
refused ('setting_missing', @() decid_identify (file, 'mass', 70));
try
  decid_identify (file, 'tilt_column', 'none', 'begin', 500);
  message = '';
catch failure
  message = failure.message;
end
assert (! isempty (strfind (message, ' begin ')));  % Octave's name, and not C's field
refused ('body_falls', @() decid_simulate ('Kp', 0, 'Kp_pass', 0));
same (decid_identify (file), jsondecode (program (decid, 'identify --json', file)));  % none of these did harm
disp ('octave: all the same');
