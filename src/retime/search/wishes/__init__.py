"""What a person asks of the timing beyond keytimes: tangents, locks, speed limits, smoothness (difficult, says §5).

An edge of the search sees three frames, so it knows the step before and the step after its middle one. Every wish is a
step that is allowed or not, or a price on steps: it costs the search no state, and the result stays the exact optimum.
"""
