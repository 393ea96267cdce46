-- What was deployed in each scene: designs and foldings that were simulated, and those that deploy. Verdicts that need no
-- simulation (twisted, locked with rigid flat pairs alone) are not counted.
SELECT base AS scene, count(DISTINCT design_id) AS designs,
       count(DISTINCT CASE WHEN status = 'deploys' THEN design_id END) AS deploying,
       count(CASE WHEN status = 'deploys' THEN 1 END) AS deploying_foldings,
       max(clearance) AS greatest_clearance, min(CASE WHEN status = 'deploys' THEN deploy_time END) AS least_time
FROM deployments
GROUP BY base
ORDER BY base;
