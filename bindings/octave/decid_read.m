% recording = decid_read (file, name, value, ...)
%
% Reads a recording, a CSV, MAT, C3D or .xlsx file.
%
%   "column", "tilt_column"   by name, or a number in quotes from 1; both are found by name; tilt "none": not read
%   "unit", "tilt_unit"       "deg", "rad" or "mrad"; otherwise from the column's name, else degrees; the tilt's is "unit" before
%   "leg", "trunk"            instead of a column of sway: columns of angles in space
%   "hip", "shoulder"         or of positions, with the person's "height" in m
%   "com_height"              or: "column" is a position at this height above the ankles, m
%   "ankle"                   column from which positions count; otherwise their means are upright. Their "unit" may be
%                             "mm", "cm" or "m"
%   "rate"                    Hz, instead of the column of time
%   "fill_gaps"               longest gap in seconds to interpolate
%   "missing"                 a number that marks a missing value, in addition to the usual ones
%   "skip_lines"              lines of a text file above its table; otherwise found
%   "invert_sway", "invert_tilt"   true: positive against the protocol's direction
%   "section"                 of a text file that holds several tables, by name, or a number in quotes from 1; a sheet by its name
%   "trial_column", "trial"   for a file of several recordings: the column that distinguishes them, and the recording to read
%                             (decid_trial_names); trial_column "none": all rows are one recording
%
% recording: a structure of sway and, if it was read, tilt (rad), rate (Hz), column and warnings (severity, code, text).
% If a centre of mass has several axes (COM_x, COM_y), sway is the first; decid_identify and decid_fit use the one
% that follows the tilt.
function recording = decid_read (file, varargin)
  recording = decid_mex ('read', file, struct (varargin{:}));
end
