% trial = decid_simulate (name, value, ...)
%
% Simulates a trial with known parameters, with the bits of the program `decid simulate`.
%
%   trial = decid_simulate ("seed", 7, "Kp", 900, "delay", 0.1);
%
%   "Kp", "Kd", "Kp_pass", "Kd_pass", "Nv", "theta", "delay"   SI units; otherwise the middle of the range
%   "seed"                                                     of the noise
%   "controller"                                               "dec", "dec2015", "ic"; otherwise the protocol's; others have
%                                                              other parameters, as `decid info --controllers` lists them
%   "protocol"                                                 "default", "short" or a JSON file
%
% trial: a structure of sway and tilt (rad), rate (Hz), and each parameter.
function trial = decid_simulate (varargin)
  trial = decid_mex ('simulate', [], struct (varargin{:}));
end
