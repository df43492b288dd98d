"""Pictures of warps: playback speed, time map, reasons, and a strip of poses."""
