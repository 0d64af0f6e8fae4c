"""An implementation of docs/theory.md, sections 1 to 6, in numpy and scipy: the judge of the program's fits.

merl (reader, index maps), slices, gamma and sgd (the model), objective (residuals of both steps), solvers (scipy and
NLopt), panel (E, L, C and albedo), document (the result). It was written from the theory alone and shares no code with
the program. Command lines: ../reference_fit.py and ../check_reference.py.
"""
