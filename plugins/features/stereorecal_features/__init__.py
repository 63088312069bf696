"""Feature matches and an essential matrix as stereorecal strategies: SIFT, XFeat, SuperPoint, and OpenCV as it is."""

from stereorecal_features._essential import Essential as Essential
from stereorecal_features._features import Features as Features
from stereorecal_features._learned import SuperPoint as SuperPoint, XFeat as XFeat
