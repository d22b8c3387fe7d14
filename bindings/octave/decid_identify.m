% result = decid_identify (recording, name, value, ...)
%
% Identifies the controller behind a recording of body sway, with the bits of the program `decid identify`.
%
%   result = decid_identify ("recording.csv", "mass", 70, "height", 1.75);
%   result = decid_identify (sway, "rate", 100, "unit", "deg");
%   result = decid_identify (sway, "rate", 100, "unit", "rad", "tilt", platform, "tilt_unit", "deg");
%   [{result.parameters.name}; {result.parameters.value}]
%
% recording: the name of a CSV, MAT, C3D or .xlsx file, or a vector of samples of the body's sway, 0 upright, positive in the
% platform's direction of tilt, with "rate" in Hz and "unit" "deg", "rad" or "mrad".
%
%   "mass", "height"        of the person, kg and m: both or none
%   "detrend"               subtract the mean of whole cycles ("offset"), a line ("linear") or nothing ("none")
%   "begin"                 the protocol's start in s after the first sample; otherwise from the measured tilt, else 0
%   "tilt"                  for samples: the platform's tilt, a vector as long as the sway. It determines where the protocol starts;
%                           decid compares its course, sign and size with the protocol's
%   "tilt_unit", "invert_sway", "invert_tilt"
%                           for samples: the tilt's unit, otherwise the sway's; true: positive against the protocol's direction
%   "model"                 a model file; otherwise the built-in model
%   "column", "unit", "rate", "fill_gaps", "tilt_column", "tilt_unit", "invert_sway", "invert_tilt", "section",
%   "trial_column", "trial", "missing", "skip_lines", "com_height", "leg", "trunk", "hip", "shoulder", "ankle"
%                           options of reading a file: see decid_read
%
% result: a structure of trust ("usable", "caution", "not usable"), parameters (a structure array of name, unit, value, sd,
% interval50, interval90, normalized over m g h, ...; struct2table makes a table of it), warnings (severity, code, text),
% rms_residual_deg, tilt_delay_s (where the protocol starts) and other figures, sway and fitted (rad, at the protocol's rate). NaN: unknown.
function result = decid_identify (recording, varargin)
  result = decid_mex ('identify', recording, struct (varargin{:}));
end
