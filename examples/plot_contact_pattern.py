"""
Contact pattern without load
============================

Pattern and transmission error as a roll tester shows them.
"""

import efficiency

pair = efficiency.load("fm_hypoid_13x42_relieved")
shape = pair.geometry("drive")
answer = float(shape.to_dict()["sides"]["drive"]["transmission_error_peak_to_peak"]) * 206265.0
print(f"transmission error {answer:.1f} arcsec peak to peak")
axes = pair.plot_contact()
