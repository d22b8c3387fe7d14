% result = decid_fit (recording, name, value, ...)
%
% Samples the posterior of a recording's parameters, in seconds to minutes, with the bits of the program `decid fit`.
% Options of decid_identify, and:
%
%   "protocol"              the protocol played: "default", "short" or a JSON file; otherwise the model's
%   "prior_start"           the recording starts at most this many s before or after the protocol
%   "prior_gain"            standard deviation of the logarithm of recorded over true sway
%   "prior_noise"           centre of the measurement noise's prior in degrees, two thirds within a factor of 20
%   "ranges"                where parameters may lie: struct ("delay", [0.05 0.2])
%   "priors"                normal distributions within the ranges, mean and standard deviation: struct ("delay", [0.12 0.02])
%   "moved_before"          true: the platform played the cycle's end before the recording
%   "max_draws"             of each chain, 8 or more
%   "seed"                  of the chains
%
% result also has quantities (sensor_noise_deg, start_s and gain, in the form of parameters), draws (a column for each
% parameter and quantity, chain by chain), chains, agreed, from_network and divergences.
function result = decid_fit (recording, varargin)
  result = decid_mex ('fit', recording, struct (varargin{:}));
end
