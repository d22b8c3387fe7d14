% study = decid_study (sheet, name, value, ...)
%
% Estimates all recordings of a study's sheet, and compares its participants, with the bits of the program `decid identify --study`,
% or of `decid fit --study`.
%
%   study = decid_study ("participants.tsv", "group", true, "within", "session", "covariates", "age,weight");
%   study.recordings{1}.parameters, study.hierarchical.comparisons
%
%   "group"                 true: compare the groups in the sheet's column group
%   "within"                "session", "condition" or "session,condition": compare them within participants
%   "covariates"            columns of numbers, such as "age,weight"
%   "fit"                   true: sample posteriors, which takes seconds to minutes per recording
%   "joint"                 of fits: fit recordings together that have the same text in this column, such as "participant_id"
%   "free"                  with "joint": parameters that differ between the texts of a column, such as "theta,Nv:condition"
%   "max_draws", "seed", "controllers"
%                           of fits, as in decid_fit; not several controllers with "joint"
%   "model"                 a model file; otherwise the built-in model
%
% study: a structure of the program's JSON (docs/guide/results.md, docs/guide/groups.md); null is [], or NaN among numbers.
% recordings is a cell array. A recording that cannot be used has an error.
function study = decid_study (sheet, varargin)
  study = jsondecode (decid_mex ('study', sheet, struct (varargin{:})));
  if ! iscell (study.recordings)
    study.recordings = num2cell (study.recordings);
  end
end
