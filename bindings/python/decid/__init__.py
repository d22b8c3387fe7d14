"""Identifies the parameters of the DEC posture-control model from recordings of body sway on a tilting platform.

    import decid
    result = decid.identify("recording.csv", mass=70, height=1.75)
    result                       # in a notebook: a table with intervals, and what to beware of
    result["Kp"].value           # N m/rad
    result.to_frame()            # for pandas

Sway is that of the body's centre of mass, 0 upright, positive in the platform's direction of tilt. Arrays that decid gives
are in rad and s, and views of its own memory: read-only. Results have the bits of the program `decid`. Bad input raises
decid.Error. Long calls take a callback, stop on Ctrl-C or whatever the callback raises, and let other threads run.
"""
from ._calls import (Dataset, Epoch, Recording, Trials, controllers, evaluate, fit, identify, read, set_threads, simulate, study, train,
                     trial_names)
from ._decid import Error, __version__
from ._network import Layer, Model, Network, ParameterInfo, Protocol
from ._results import Body, ComparedController, Evaluation, Fit, Notice, Parameter, Result, Sampling, Study, TiltMatch

__all__ = [
    "Body", "ComparedController", "Dataset", "Epoch", "Error", "Evaluation", "Fit", "Layer", "Model", "Network", "Notice", "Parameter",
    "ParameterInfo", "Protocol", "Recording", "Result", "Sampling", "Study", "TiltMatch", "Trials", "controllers", "evaluate", "fit", "identify",
    "read", "set_threads", "simulate", "study", "train", "trial_names",
]
