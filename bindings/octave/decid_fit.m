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
%   "priors"                normal distributions within the ranges, mean and standard deviation: struct ("delay", [0.12 0.02]).
%                           Both also over the body's m g h, in Octave only: struct ("Kp/mgh", [1.0 0.2])
%   "moved_before"          true: the platform played the cycle's end before the recording
%   "max_draws"             of each chain, 8 or more
%   "seed"                  of the chains
%   "controllers"           such as "dec,dec2015,ic": each is fitted, and the result is of the first one; otherwise the
%                           protocol's. Ranges and priors act on the controllers that have the parameter
%
% result also has quantities (sensor_noise_deg, start_s and gain, in the form of parameters), draws (a column for each
% parameter and quantity, chain by chain), chains, agreed, from_network, divergences and comparison: a structure array with
% an element for each controller, if there are several, of controller, log_predictive_density (leave-one-out, nats),
% difference to the largest density (nats: 0 or below), difference_standard_error, weight (stacking) and comparable (false:
% its chains are far apart or it has an invalid warning; ignore its numbers).
%
%   fit = decid_fit ("recording.csv", "controllers", "dec,dec2015,ic");
%   [{fit.comparison.controller}; {fit.comparison.difference}; {fit.comparison.difference_standard_error}]
function result = decid_fit (recording, varargin)
  result = decid_mex ('fit', recording, struct (varargin{:}));
end
