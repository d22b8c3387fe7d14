% result = decid_fit (recording, name, value, ...)
%
% Samples the posterior of what a recording says, in seconds to minutes, with the bits of the program `decid fit`. As
% decid_identify, and:
%
%   "protocol"              what was played: "default", "short" or a JSON file; otherwise the model's
%   "prior_start"           largest distance in s between recording's and protocol's start
%   "prior_gain"            standard deviation of the logarithm of recorded over true sway
%   "prior_noise"           of the sensor, degrees, to a factor of 20
%   "ranges"                where parameters may lie: struct ("delay", [0.05 0.2])
%   "priors"                normal distributions, mean and standard deviation: struct ("delay", [0.12 0.02])
%   "moved_before"          true: the platform played the cycle's end before the recording
%   "max_draws"            of each chain, 8 or more
%   "seed"                  of the chains
%
% result also has quantities (as parameters: sensor_noise_deg, start_s, gain), draws (a column for each of both, chain by
% chain), chains, agreed, from_network and divergences.
function result = decid_fit (recording, varargin)
  result = decid_mex ('fit', recording, struct (varargin{:}));
end
