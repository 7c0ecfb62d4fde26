"""What a sound calibration rests on."""

from __future__ import annotations

from endocal.calibration.quality import Evidence

GOOD = Evidence(
    lines=25,
    points=8000,
    rms_before=2.3,
    rms=0.1,
    entropy=6.0,
    lam=-2.8e-6,
    lam_sigma=1e-9,
    center_sigma=0.1,
    center_belief=46.0,
    reach=300.0,
    content_radius=380.0,
    fold_radius=597.0,
    short_side=576.0,
    explained=0.7,
    board=True,
)
