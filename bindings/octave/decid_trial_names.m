% names = decid_trial_names (file, trial_column, name, value, ...)
%
% The recordings of a file that holds several, in the order in which they begin: a cell array of names for decid_read.
%
%   for name = decid_trial_names ("long.csv", "subject,trial")
%     result = decid_identify ("long.csv", "trial_column", "subject,trial", "trial", name{1});
%   end
%
%   "section", "skip_lines"   of a text file: see decid_read
function names = decid_trial_names (file, trial_column, varargin)
  names = decid_mex ('trial_names', file, struct ('trial_column', trial_column, varargin{:}));
end
